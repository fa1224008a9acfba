pbdsurg_room(tissue
  HEADERS material.h thermal_properties.h
  SOURCES material.cpp thermal_properties.cpp)
