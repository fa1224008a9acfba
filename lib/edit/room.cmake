pbdsurg_room(edit
  HEADERS live_boundary.h topology_edit.h
  SOURCES edit_checks.cpp fingerprint.cpp live_boundary.cpp part_tissue.cpp removal.cpp split_tets.cpp topology_edit.cpp)
