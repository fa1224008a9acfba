pbdsurg_room(thermal
  HEADERS heat_field.h potential_field.h thermal_mesh.h thermal_model.h tissue.h tissue_state.h
  SOURCES heat_field.cpp heat_region.cpp heat_step.cpp local_system.cpp potential_field.cpp
          potential_region.cpp thermal_mesh.cpp thermal_model.cpp tissue.cpp)
