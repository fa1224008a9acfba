pbdsurg_room(edit
  HEADERS cut.h live_boundary.h topology_edit.h
  SOURCES cut.cpp cut_planner.cpp cut_surface.cpp live_boundary.cpp topology_edit.cpp)
