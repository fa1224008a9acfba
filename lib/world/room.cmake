pbdsurg_room(world
  HEADERS surface.h world.h
  SOURCES body_table.cpp edit_merge.cpp surface.cpp world.cpp)
