pbdsurg_room(thermal
  HEADERS heat_field.h thermal_mesh.h tissue.h
  SOURCES heat_field.cpp thermal_mesh.cpp)
