pbdsurg_room(views
  HEADERS change_log.h live_boundary.h live_pieces.h live_surface.h
  SOURCES change_log.cpp live_boundary.cpp live_pieces.cpp live_surface.cpp)
