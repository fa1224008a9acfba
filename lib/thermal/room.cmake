pbdsurg_room(thermal
  HEADERS heat_field.h tissue.h
  SOURCES heat_field.cpp local_system.cpp)
