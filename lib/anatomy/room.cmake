pbdsurg_room(anatomy
  HEADERS organs.h
  SOURCES organs.cpp)
