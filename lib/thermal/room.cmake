pbdsurg_room(thermal
  HEADERS generator.h heat_field.h thermal_model.h tissue.h tissue_color.h tissue_state.h
  SOURCES generator.cpp heat_field.cpp thermal_model.cpp tissue.cpp)
