pbdsurg_room(contact
  HEADERS proximity.h
  SOURCES proximity.cpp)
