pbdsurg_room(surgery
  HEADERS cautery.h
  SOURCES cautery.cpp)
