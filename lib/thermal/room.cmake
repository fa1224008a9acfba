pbdsurg_room(thermal
  HEADERS disk_source.h generator.h heat_field.h potential_field.h surface_map.h surface_texture.h
          thermal_mesh.h thermal_model.h tissue_color.h tissue_state.h
  SOURCES contact_region.cpp device_system.cpp disk_source.cpp generator.cpp heat_field.cpp
          heat_region.cpp heat_step.cpp local_system.cpp potential_field.cpp potential_region.cpp
          region_conductances.cpp region_joints.cpp surface_map.cpp surface_texture.cpp
          thermal_mesh.cpp thermal_model.cpp)
