pbdsurg_room(mesh
  HEADERS mesh_data.h tet_mesh.h topology.h implicit_shape.h surface_distance.h tetrahedralize.h
  SOURCES tet_mesh.cpp topology.cpp implicit_shape.cpp surface_distance.cpp
          triangle_orientation.cpp lattice.cpp stuffing.cpp boundary_check.cpp smoothing.cpp
          tetrahedralize.cpp)
