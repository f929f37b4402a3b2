"""Triangle meshes: the value, reading them from files, and folders of them by category."""

from viewgain.meshes._entry import MeshEntry as MeshEntry
from viewgain.meshes._file import MAX_FACES as MAX_FACES
from viewgain.meshes._mesh_folder import MeshFolder as MeshFolder
from viewgain.meshes._read import read_mesh as read_mesh
from viewgain.meshes._triangle_mesh import TriangleMesh as TriangleMesh
