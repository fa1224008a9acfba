pbdsurg_room(edit
  HEADERS live_boundary.h live_pieces.h live_surface.h topology_edit.h undo_array.h
  SOURCES live_boundary.cpp live_pieces.cpp live_surface.cpp topology_edit.cpp)
