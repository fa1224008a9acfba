pbdsurg_room(coloring
  HEADERS coloring.h
  SOURCES coloring.cpp)
