"""Every volumetric metric as a policy: scans go into a voxel grid, the metric scores the candidates on it."""

from viewgain.arrays import Vector
from viewgain.gain import GridKnown, Objective
from viewgain.plan._views import Seen
from viewgain.scans import Scan
from viewgain.voxels import OCTOMAP, Backend, Evidence, Lattice, OccupancyModel, VoxelGrid, coarser, evidence, pixels_per_voxel


class Mapper:
    """Fills a grid from scans, and remembers what each scan said, and the last situation: policies may share one.

    What it remembers changes no answer, only the time it takes. It keeps the scans it was shown: one mapper per world.
    """

    def __init__(
        self,
        lattice: Lattice,
        *,
        model: OccupancyModel = OCTOMAP,
        empty_is_free: bool = False,
        stride: int | None = None,
        step: int | None = None,
        backend: Backend = "auto",
    ) -> None:
        """Remember nothing yet.

        Args:
            lattice: The voxels, world frame.
            model: How strongly a scan speaks.
            empty_is_free: Whether a pixel without a return has looked through the lattice (:func:`viewgain.voxels.evidence`).
            stride: Every ``stride``-th pixel of a scan frees what lies before it; None for three along the edge of a voxel.
            step: Candidates are judged with every ``step``-th pixel per row and column; None for one along the edge of a voxel.
            backend: Who casts the rays.
        """
        self.lattice = lattice
        self.model = model
        self._empty_is_free = empty_is_free
        self._stride = stride
        self._step = step
        self._backend: Backend = backend
        self._said: dict[int, tuple[Scan, Evidence]] = {}
        self._last: tuple[tuple[int, ...], GridKnown] | None = None

    def grid(self, scans: tuple[Scan, ...]) -> VoxelGrid:
        """Return the grid after the scans, in their order; empty without any.

        Raises:
            ScanError: If a scan has no pose, or no image where empty pixels shall speak.
        """
        return VoxelGrid.empty(self.lattice, self.model).plus([self._evidence(scan) for scan in scans])

    def known(self, seen: Seen) -> GridKnown:
        """Return what a metric looks at; the same object for the same situation."""
        key = tuple(map(id, seen.scans))
        step = self._step or min(pixels_per_voxel(self.lattice, seen.camera, pose[:3, 3]) for pose in seen.candidates)
        camera = coarser(seen.camera, step)
        last = self._last
        if last is None or last[0] != key or last[1].candidates is not seen.candidates or last[1].camera != camera:
            self._last = last = (key, GridKnown(self.grid(seen.scans), seen.candidates, camera, self._backend))
        return last[1]

    def _evidence(self, scan: Scan) -> Evidence:
        if id(scan) not in self._said:  # the scan is kept beside what it said, so its id is not given away again
            stride = self._stride or self._own_stride(scan)
            said = evidence(self.lattice, scan, empty_is_free=self._empty_is_free, stride=stride, backend=self._backend)
            self._said[id(scan)] = (scan, said)
        return self._said[id(scan)][1]

    def _own_stride(self, scan: Scan) -> int:
        if scan.intrinsics is None or scan.camera_to_world is None:
            return 1
        return max(pixels_per_voxel(self.lattice, scan.intrinsics, scan.camera_to_world[:3, 3]) // 3, 1)


class VolumetricPolicy:
    """Scores candidates by a volumetric metric."""

    def __init__(self, metric: Objective[GridKnown], mapper: Mapper) -> None:
        """Take a metric, e.g. one of :data:`viewgain.gain.VOLUMETRIC`, and who fills the grid for it."""
        self.metric = metric
        self.mapper = mapper

    @property
    def name(self) -> str:
        """The metric's."""
        return self.metric.name

    def scores(self, seen: Seen) -> Vector:
        """Return (V,) gains by the metric."""
        return self.metric.gains(self.mapper.known(seen))
