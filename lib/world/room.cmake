pbdsurg_room(world
  HEADERS surface.h world.h
  SOURCES edit_merge.cpp surface.cpp world.cpp)
