pbdsurg_room(tissue
  HEADERS library.h look.h material.h thermal_properties.h
  SOURCES library.cpp material.cpp thermal_properties.cpp)
