pbdsurg_room(mesh
  HEADERS mesh_data.h tet_mesh.h topology.h
          length_unit.h read.h write.h series.h quality.h check.h
  SOURCES tet_mesh.cpp topology.cpp
          length_unit.cpp quality.cpp check.cpp point_check.cpp surface_check.cpp
          source.cpp cells.cpp point_ids.cpp xml_reader.cpp encoded_stream.cpp
          read.cpp read_msh.cpp read_vtk.cpp read_vtu.cpp read_tetgen.cpp read_medit.cpp
          read_stl.cpp read_obj.cpp read_ply.cpp
          output.cpp write.cpp write_msh.cpp write_vtk.cpp write_vtu.cpp write_surface.cpp
          series.cpp)
