pbdsurg_room(thermal
  HEADERS disk_source.h generator.h heat_field.h thermal_model.h tissue.h tissue_color.h tissue_state.h
  SOURCES disk_source.cpp generator.cpp heat_field.cpp thermal_model.cpp tissue.cpp)
