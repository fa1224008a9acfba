pbdsurg_room(mesh
  HEADERS mesh_data.h tet_mesh.h topology.h
  SOURCES tet_mesh.cpp topology.cpp)
