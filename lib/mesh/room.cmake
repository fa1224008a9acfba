pbdsurg_room(mesh
  HEADERS mesh_data.h tet_mesh.h topology.h
          length_unit.h read.h
  SOURCES tet_mesh.cpp topology.cpp
          length_unit.cpp read.cpp
          source.cpp cells.cpp point_ids.cpp xml_reader.cpp encoded_stream.cpp
          read_msh.cpp read_vtk.cpp read_vtu.cpp read_tetgen.cpp read_medit.cpp
          read_stl.cpp read_obj.cpp read_ply.cpp)
