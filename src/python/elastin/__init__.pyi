from os import PathLike
from typing import Any, Callable, Iterable, Iterator, Literal, Mapping, Sequence, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

__version__: str

Path = Union[str, PathLike[str]]
Changes = Union[Mapping[str, Any], Sequence[str], None]
Progress = Union[Callable[[str], object], bool, None]
Scene = Union[Path, Mapping[str, Any], "Body"]
Outcome = Literal["converged", "limit_reached", "inverted", "diverged", "mechanism", "interrupted", "unsuited"]
Floats = NDArray[np.float64]
Ints = NDArray[np.int32]

class InputError(ValueError):
    """Wrong use or wrong input: file:line:column, the key, what was given, what is allowed, the nearest name."""
class MissingFileError(InputError, FileNotFoundError):
    """A file that is not there: InputError and FileNotFoundError."""
class StepError(RuntimeError):
    """A step that failed, or an equilibrium that was not found: outcome and cause. `result` is the StepResult or
    StaticResult."""
    result: "StepResult | StaticResult"

class Body:
    """A piece of tissue at rest: molecules joined by connections. It never changes; its arrays are views that cannot be
    written to."""
    def __init__(self, positions: ArrayLike, connections: ArrayLike | None = None, *,
                 triangles: ArrayLike | None = None, tetrahedra: ArrayLike | None = None,
                 cells: Mapping[str, ArrayLike] = ..., rest_lengths: ArrayLike | None = None,
                 masses: ArrayLike | None = None, radii: ArrayLike | None = None, density: float = 1000.0,
                 thickness: float = 0.0, growth: ArrayLike | None = None, stiffness: ArrayLike | None = None) -> None:
        """positions (n, 3) [m]; connections (m, 2), numbers of molecules, by default the sides of the cells; triangles
        (k, 3); tetrahedra (k, 4); cells of other shapes by name, {'hexahedron8': (k, 8), …}, nodes as in VTK;
        rest_lengths (m,) [m], by default the distances; masses (n,) [kg], by default from density [kg/m^3], by
        default that of the material with which the body is used, and the cells (triangles: thickness [m]) or the
        convex hull; radii (n,) [m], by default half the shortest connection; growth (n, 3, 3), where each cell is
        unstressed, F_g, by default as it lies at rest: all of it acts from the start; stiffness (k,), how many times
        as stiff as the material each cell is, by default 1: moduli[labels] / E of an array of labels. Arrays are
        copied."""
    @property
    def positions(self) -> Floats:
        """Positions at rest [m], (n, 3)."""
    @property
    def masses(self) -> Floats:
        """[kg], (n,)."""
    @property
    def radii(self) -> Floats:
        """[m], (n,)."""
    @property
    def connections(self) -> Ints:
        """The two molecules of each connection, (m, 2); sides of cells only come last."""
    @property
    def rest_lengths(self) -> Floats:
        """Unstressed lengths of the connections [m], (m,)."""
    @property
    def triangles(self) -> Ints:
        """(k, 3)."""
    @property
    def tetrahedra(self) -> Ints:
        """(k, 4), turned to positive volume."""
    @property
    def surface(self) -> Ints:
        """Triangles of its surface, (k, 3), counter-clockwise seen from outside: the faces of its solid cells, else of
        a lattice's cubes, and its triangles; a copy. A cut makes another."""
    @property
    def cells(self) -> dict[str, Ints]:
        """Every cell by its shape: {'tetrahedron4': (k, 4), 'hexahedron20': (k, 20), …}, copies; triangles only where
        there are no solids."""
    @property
    def proper_connections(self) -> int:
        """How many connections are more than sides of cells; they come first."""
    def __len__(self) -> int: ...
    @staticmethod
    def from_meshio(mesh: Any, length_unit: Literal["m", "cm", "mm", "um", "nm"] = "m", **options: Any) -> Body:
        """The body of a meshio.Mesh, or of a file that meshio reads, in length_unit "m", "cm", "mm", "um" or "nm". Its
        solid cells; without such cells its surface cells; without these its lines as connections. Points that
        nothing uses are left out. Options go to Body: density, thickness."""
    def plot(self, ax: Any = None, **options: Any) -> Any:
        """The body at rest in 3D. Options go to Line3DCollection."""
    def view(self) -> View:
        """The body at rest in 3D: a View."""
    def to_vtu(self, path: Path) -> None:
        """Writes the body at rest as a VTU file: its cells, its connections as lines, mass and radius of its molecules."""
    def to_meshio(self) -> Any:
        """A meshio.Mesh of the body at rest."""
    def to_pyvista(self) -> Any:
        """A pyvista.UnstructuredGrid of the body at rest."""

class Surface:
    """A surface that is drawn with a body and takes no part in its mechanics, as fine as a picture wants it: each point
    moves with the solid cell, or the lattice's cube, that holds it at rest or is nearest."""
    def __init__(self, body: Body, points: ArrayLike, triangles: ArrayLike) -> None:
        """points (n, 3) [m] in the body's shape at rest; triangles (k, 3) of their numbers, counter-clockwise seen from
        outside."""
    def draw(self, positions: ArrayLike) -> tuple[Floats, Floats]:
        """Where the points are when the molecules are at `positions` (m, 3) [m], and the unit normals there: two arrays
        (n, 3) in single precision, as graphics take them."""
    @property
    def farthest(self) -> float:
        """How far the point that is furthest from all cells lies outside of them [m], about."""
    def __len__(self) -> int: ...

class Material:
    """What a body should behave like; SI units."""
    def __init__(self, youngs_modulus: float | None = None, poissons_ratio: float = 0.25, density: float = 1000.0, *,
                 thickness: float = 0.0, bending_rigidity: float = 0.0,
                 curve: Sequence[tuple[float, float]] | None = None, fibre_direction: ArrayLike | None = None,
                 fibre_modulus: float | None = None, law: Mapping[str, Any] | None = None,
                 relaxation: Sequence[tuple[float, float]] | None = None, instantaneous: bool = False) -> None:
        """youngs_modulus [Pa] > 0 or `curve`, pairs (strain, stress [Pa]) in uniaxial stress; poissons_ratio from -0.99
        to 0.5; density [kg/m^3]; of sheets their thickness [m] and bending_rigidity [N m]; of fibres their direction
        and modulus [Pa]; law: a dict of the law's name and its constants as scenes have them, {'law': 'ogden',
        'terms': [[6.3e5, 1.3]], 'bulk_modulus': 1e9}, and youngs_modulus and poissons_ratio follow; a law of one's
        own stands there itself, {'law': mine, 'k': 3e4, 'direction': (0, 0, 1)}; relaxation: pairs (share, time [s])
        of strategies 'prony:NAME', of long-term moduli or of instantaneous ones."""
    @property
    def youngs_modulus(self) -> float:
        """E [Pa]; of a curve its slope at no strain, of a law at rest."""
    @property
    def poissons_ratio(self) -> float:
        """Poisson's ratio."""
    @property
    def density(self) -> float:
        """[kg/m^3]"""
    @property
    def thickness(self) -> float:
        """[m], of a membrane."""
    @property
    def bending_rigidity(self) -> float:
        """[N m]; 0 = no bending stiffness."""
    @property
    def law(self) -> str | None:
        """Name of the law whose constants it has, or None."""

class Parameter:
    """A value that a strategy, a stepper or a load takes, described once."""
    def __init__(self, name: str, default: float, *, low: float = ..., high: float = ..., text: str = "") -> None:
        """Of a strategy of one's own, in SI units; low and high are allowed, too."""
    @property
    def name(self) -> str: ...
    @property
    def default(self) -> float: ...
    @property
    def low(self) -> float: ...
    @property
    def high(self) -> float: ...
    @property
    def text(self) -> str: ...
    @property
    def required(self) -> bool: ...
    @property
    def kind(self) -> str:
        """'number', 'whole number', 'vector', 'direction' or 'molecules'."""
    @property
    def unit(self) -> str: ...

class Row:
    """What a stepper, a linear solver or a load says of itself."""
    @property
    def name(self) -> str: ...
    @property
    def summary(self) -> str: ...
    @property
    def source(self) -> str: ...
    @property
    def parameters(self) -> list[Parameter]: ...

class Load(Row):
    """A load of one's own, see elastin.load."""

class Stepper(Row):
    """A stepper of one's own, see elastin.stepper."""

class Strategy:
    """A method that gives a body's connections their stiffness."""
    def __init__(self, name: str, constants: Callable[..., ArrayLike], *, summary: str = "", source: str = "",
                 parameters: Sequence[Parameter] = ...,
                 unsuited: Callable[[Body], str | None] | None = None) -> None:
        """A spring rule of one's own: constants(body, material, **parameters) gives the spring constants [N/m], one a
        connection; unsuited(body) says why it cannot run on a body, or None."""
    @property
    def name(self) -> str: ...
    @property
    def summary(self) -> str: ...
    @property
    def source(self) -> str: ...
    @property
    def kind(self) -> str:
        """'spring rule', 'spring rule, updated', 'cell law' or 'wrapper'."""
    @property
    def parameters(self) -> list[Parameter]: ...
    def constants(self, body: Body, material: Material, parameters: Mapping[str, float] = ...) -> Floats:
        """The spring constants [N/m] that a spring rule gives a body, (m,)."""

class Catalog:
    """Strategies by name: those of Elastin, and one's own."""
    def __init__(self) -> None:
        """Those that come with Elastin."""
    def add(self, own: Strategy | Load | Stepper) -> None:
        """A strategy, a load or a stepper of one's own, which scenes then may name; its name must be new."""
    @property
    def names(self) -> list[str]: ...
    def __getitem__(self, name: str) -> Strategy: ...
    def __len__(self) -> int: ...
    def __iter__(self) -> Iterator[Strategy]: ...

class Trajectory:
    """Equal steps that can be differentiated, see Simulation.trajectory."""
    @property
    def positions(self) -> Floats:
        """Of the end [m], (n, 3)."""
    @property
    def velocities(self) -> Floats:
        """Of the end [m/s], (n, 3)."""
    def vjp(self, positions: ArrayLike | None = None, velocities: ArrayLike | None = None) -> dict[str, Any]:
        """What a function of the end changes with, by one sweep backward: from its derivatives by positions and
        velocities there, each (n, 3) or None, a dict of those by 'positions' and 'velocities' at the start and by
        'forces' on molecules throughout, each (n, 3), and a list, 'stiffness', as that of Simulation.vjp, whose
        arrays are empty where `rayleigh` damps by the stiffness."""

class StepResult:
    """How a step ended; true if it went well."""
    @property
    def outcome(self) -> Outcome: ...
    @property
    def cause(self) -> str:
        """Why it did not get there; the state then stayed as it was."""
    @property
    def substeps(self) -> int:
        """Into how many substeps it was divided."""
    @property
    def newton_iterations(self) -> int: ...
    @property
    def linear_iterations(self) -> int: ...
    def __bool__(self) -> bool: ...

class StaticResult:
    """How the search for an equilibrium ended; true if it was found."""
    @property
    def outcome(self) -> Outcome: ...
    @property
    def cause(self) -> str: ...
    @property
    def solver(self) -> str: ...
    @property
    def newton_iterations(self) -> int: ...
    @property
    def linear_iterations(self) -> int: ...
    @property
    def residual(self) -> float:
        """Unbalanced force over the size of loads and reactions; where these are nothing, of the forces within the
        body."""
    @property
    def left_saddle(self) -> bool:
        """Whether it went down from an equilibrium that was no minimum, as a column that buckles does."""
    @property
    def unstable(self) -> bool:
        """Whether the equilibrium found has a direction of negative stiffness: the body does not stay there."""
    def __bool__(self) -> bool: ...

class SimulationState:
    """All that a simulation changes while it runs."""
    @property
    def time(self) -> float:
        """[s]"""
    @property
    def positions(self) -> Floats:
        """[m], (n, 3)."""

class TopologyReport:
    """What a cut did; true if it changed anything."""
    @property
    def split_molecules(self) -> int: ...
    @property
    def removed_connections(self) -> int: ...
    @property
    def removed_cells(self) -> int: ...
    @property
    def molecule_from(self) -> Any:
        """Of each molecule its number before, (n,); those that were split off come last."""
    @property
    def connection_from(self) -> Any:
        """Of each connection its number before, (m,)."""
    def __bool__(self) -> bool: ...

class Simulation:
    """A body that moves. Steps let other Python threads run; each simulation may run in a thread of its own. Views
    never copy: they stay where they are, and keep the simulation alive."""
    def __init__(self, body: Body, strategy: str | Strategy,
                 material: Material | Sequence[Material] | Mapping[str, Any] | str, *, stepper: str | Stepper = "symplectic_euler", safety: float = 0.8, max_substeps: int = 1000,
                 stepper_parameters: Mapping[str, float] = ..., parameters: Mapping[str, float] = ...,
                 budget: float = 0.0, catalog: Catalog | None = None, scheme: str | Stepper | None = None,
                 scheme_parameters: Mapping[str, float] | None = None) -> None:
        """material: one, or of a body of parts (see of_parts) a list, which the parts count from 0. strategy: a name
        ('lattice', 'lattice+volume', 'calibrated:patch') or a Strategy. calibrated: fits a rule to the material by
        the body's homogenised stiffness, as the experiment `material` of a scene does; the body is of tetrahedra, or
        a box. What strategy and material need of the body is added: pairs of molecules for bending_rigidity, sides
        of cells, Voronoi cells. stepper: one of steppers() or one's own (see elastin.stepper), and
        stepper_parameters its own by name: {'newton_iterations': 1}. Explicit steppers part a step so that each part
        is at most `safety` of the body's stable step; a step that would take more than max_substeps is not taken.
        parameters: of the strategy, by name. budget: by the clock, what a step may take [s]; 0: any. Of steppers
        that take a number of sweeps or iterations: each step gets as many as the pace of the steps before leaves
        time for; see effort. scheme, scheme_parameters: former names of stepper, stepper_parameters."""
    @property
    def body(self) -> Body: ...
    @property
    def time(self) -> float:
        """[s]"""
    @property
    def positions(self) -> Floats:
        """[m], (n, 3): a view that changes with each step. To be set between steps where the body is to be elsewhere:
        velocities stay, and supports where they are."""
    @positions.setter
    def positions(self, positions: ArrayLike) -> None: ...
    @property
    def velocities(self) -> Floats:
        """[m/s], (n, 3): a view that changes with each step. May be set between steps."""
    @velocities.setter
    def velocities(self, velocities: ArrayLike) -> None: ...
    @property
    def forces(self) -> Floats:
        """All forces of the state reached [N], (n, 3): a view. Asking for it fills it: a view that was requested before
        a step shows that earlier state until it is requested again."""
    @property
    def tensions(self) -> Floats:
        """Of each connection [N], pulling is positive, (m,): a view, as forces."""
    @property
    def host_forces(self) -> Floats:
        """Forces of one's own [N], (n, 3): a view to write to. They act from the next step on until changed."""
    def step(self, dt: float, count: int = 1, *, check: bool = True) -> StepResult:
        """Brings the body forward by dt [s], `count` times, and gives the last step's result. A step that fails leaves
        the state as it was and raises StepError; with check=False its result says so, and no step follows."""
    def settle(self, *, check: bool = True) -> StaticResult:
        """Goes to the equilibrium of all that acts now, at rest: a start. Couplings rest, too: their dampers have no
        part in it, and their velocities are 0 until move_coupling gives others. One that is no minimum is left; the
        result's `unstable` says where that did not succeed. Raises StepError where none is found, unless
        check=False."""
    @property
    def warnings(self) -> list[str]:
        """What makes its results doubtful, a sentence each: pieces, cells given twice, negative spring constants,
        mechanisms, cells that lock, a missing thickness, a budget that is not kept. Looks at the whole body: not for
        every step."""
    def observe(self, see: Callable[[Simulation], object], every: int = 1) -> None:
        """Calls see(simulation) after every `every` steps that succeeded. It must not step; what it raises ends the
        step() that it came from."""
    def save(self) -> SimulationState:
        """The state to go on from, bitwise identically."""
    @property
    def effort(self) -> int:
        """Sweeps or iterations of the last step; 0 where the stepper takes no number of them. With a budget it differs
        from step to step and from machine to machine: record it and pass it to set_effort to reproduce the run."""
    def set_effort(self, effort: int) -> None:
        """From now on this count, whatever the budget says: steps are then bitwise identical again."""
    def iteration_error(self, dt: float) -> tuple[float, float]:
        """What so few sweeps or iterations would do to a next step by dt [s], which is tried and taken back: the
        largest distance of a molecule from where backward Euler's balance to the end has it, and the largest
        distance that it goes there [m]. NaN where one of the two fails."""
    def restore(self, saved: SimulationState) -> None:
        """Goes back, or on, to a saved state; across cuts, too. Raises InputError where other positions at rest, or
        another sum of spring constants before a cut, show that it is another body's; other materials, connections
        and cells are not noticed."""
    def cut_plane(self, point: ArrayLike, normal: ArrayLike) -> TopologyReport:
        """Parts the body by a plane in its present positions [m], between its cells, or between molecules where it has
        none. Volume and mass stay. Molecules keep their numbers; those that were split off come last. Views show
        what was before: request new ones. The next step takes longer."""
    def cut_blade(self, start: ArrayLike, end: ArrayLike) -> TopologyReport:
        """The same by what a straight blade sweeps: its two ends [m], (2, 3), where it starts and where it ends."""
    def cut_triangles(self, points: ArrayLike, triangles: Sequence[Sequence[int]]) -> TopologyReport:
        """The same by triangles of points [m]."""
    def tear(self, strain: float) -> TopologyReport:
        """Parts the body where it is strained above `strain`; a crack through cells grows by one molecule a call."""
    def remove(self, connections: Sequence[int] = ..., cells: Sequence[int] = ...) -> TopologyReport:
        """Removes connections and cells by number or by masks, with the cells' mass; molecules that lose all are gone,
        and those behind them are renumbered."""
    @property
    def origin(self) -> list[int]:
        """Of each molecule its number in the body that the simulation was made of."""
    def add_tool(self, position: ArrayLike, turn: ArrayLike | None = None) -> int:
        """A rigid thing that one moves, an instrument: its position [m] and its rotation, a 3 x 3 matrix. Gives its
        number, which obstacles of add_contact take as their tool."""
    def move_tool(self, tool: int, position: ArrayLike, turn: ArrayLike | None = None) -> None:
        """Where a tool is to be at the end of the next step [m]: it goes there at constant speed, and stays. Without a
        turn it keeps its own."""
    def add_contact(self, stiffness: float, obstacles: Sequence[Mapping[str, Any]] = ..., *, friction: float = 0.0,
                    restitution: float = 1.0, penetration: float = 0.0,
                    surface: Literal["triangles", "spheres"] = "triangles", self_contact: bool = False) -> None:
        """Contact with obstacles and between pieces, at any time between steps. stiffness [Pa/m]: pressure over depth.
        Each obstacle is a dict: shape 'plane' (z < 0), 'box' (x, y, z), 'sphere' (radius), 'cylinder' or 'capsule'
        (radius, length), 'convex' (points, their hull) or 'mesh' (points, closed triangles) [m]; where it is: tool,
        or position and turn; friction and name if one likes. surface: 'triangles', or 'spheres' of the molecules,
        which a cut leaves without a force."""
    def contact_torques(self) -> dict[str, Floats]:
        """Torque of the body on each obstacle by its name [N m], about where the obstacle, or its tool, is now."""
    def contact_points(self) -> dict[str, Any]:
        """Where the body is pressed now: a dict of 'position' (k, 3) [m], 'force' on the body (k, 3) [N], and
        'obstacle', a list of names, '' where it touches itself."""
    def contact_forces(self) -> dict[str, Floats]:
        """Force of the body on each obstacle by its name [N]."""
    def fix(self, molecule: int | ArrayLike, free: str | ArrayLike = "") -> None:
        """Holds a molecule, or each of an array or a mask of them, where it is, but in the directions that `free`
        names: 'z', 'xy', or a 3 x 3 projector."""
    def release(self, molecule: int | ArrayLike) -> None:
        """Releases a fixed molecule, or each of an array of them."""
    def move_to(self, molecule: int | ArrayLike, position: ArrayLike) -> None:
        """Where a held molecule is to be at the end of the next step [m]; of an array of them (k, 3)."""
    def reaction(self, molecule: int | ArrayLike) -> Floats:
        """Force of its support on a held molecule [N]; zero where nothing holds it. Of an array of them (k, 3)."""
    def vjp(self, positions: ArrayLike | None = None, reactions: ArrayLike | None = None) -> dict[str, Any]:
        """What a function of the equilibrium that settle() has found changes with, by one linear solve: from its
        derivatives by positions and by reactions of fixed molecules, each (n, 3) or None, a dict of those by
        'forces' on molecules (n, 3), by the 'displacement' of fixed molecules (n, 3), and a list, 'stiffness', of
        arrays, one a law: by the logarithm of each element's stiffness, which is k dm/dk of a spring, and of a cell
        E dm/dE. An array is empty where a law is no sum of elements."""
    def jvp(self, *, forces: ArrayLike | None = None,
            displacement: ArrayLike | None = None,
            stiffness: Sequence[ArrayLike] = ...) -> tuple[Floats, Floats]:
        """How positions and reactions, each (n, 3), of the equilibrium that settle() has found change with forces on
        all molecules and displacements of fixed ones, (n, 3), and the logarithms of the stiffness of all elements, a
        list as vjp() gives it: a derivative along these."""
    def trajectory(self, dt: float, steps: int, stepper: str = "symplectic_euler",
                   parameters: dict[str, float] = ..., *, scheme: str | None = None) -> Trajectory:
        """Takes equal steps by dt [s] from the present state, which stays as it is, so that their end can be
        differentiated. Steppers: symplectic_euler, velocity_verlet, backward_euler, newmark, generalized_alpha, with
        their parameters by name; explicit ones must be given steps short enough, for no step is split. Nothing that
        acts on the body may change until the last vjp(). scheme: former name of stepper."""
    def couple(self, molecule: int, position: ArrayLike, stiffness: float, damping: float = 0.0) -> int:
        """A spring [N/m] and damper [N s/m] between a molecule and a position [m]: a tool. Gives the coupling's number."""
    def move_coupling(self, coupling: int, position: ArrayLike, velocity: ArrayLike = ...) -> None:
        """[m], [m/s]"""
    def coupling_force(self, coupling: int) -> Floats:
        """Force of the coupling on its molecule [N] in the state reached. Under newmark and energy_momentum that of a
        stiff coupling swings about its mean from one step to the next, where the step is long for the coupling's own
        vibration: take backward_euler or generalized_alpha there."""
    def decouple(self, coupling: int) -> None: ...
    def add_load(self, load: str | Load, **kwargs: float | ArrayLike) -> int:
        """Adds a load or damping, one of loads() or one's own (see elastin.load), at any time between steps:
        add_load('gravity', acceleration=(0, 0, -9.81)). Gives its number for set_load and remove_load."""
    def set_load(self, load: int, **kwargs: float | ArrayLike) -> None:
        """Gives a load other values from the next step on, by its number: all of them, as add_load."""
    def remove_load(self, load: int) -> None:
        """Takes a load away, by its number."""
    def plot(self, ax: Any = None, **options: Any) -> Any:
        """The body as it is now, its connections coloured by their tension. Options go to Line3DCollection."""
    def vibrations(self, count: int = 6) -> tuple[Floats, Floats]:
        """The slowest free vibrations about the present state, an equilibrium, small and without damping: frequencies
        (k,) [Hz], 0 of a mechanism and NaN where it is unstable, and shapes (k, n, 3) of unit modal mass, sum of m
        |u|^2 = 1 [1/sqrt(kg)]. Supports hold; rigid motions are left out."""
    def cell_states(self) -> dict[str, dict[str, Floats]]:
        """Means over each cell now, by shape as in Body.cells: {'tetrahedron4': {'strain': (k, 3, 3), 'stress': (k, 3,
        3)}, …}: Green and Lagrange's strain and Cauchy's stress [Pa], of triangles force over width [N/m]: those of
        the law in the cell; of springs the virial of its sides."""
    def tangent(self) -> tuple[Floats, Ints, Ints]:
        """The stiffness -d(all forces)/d(positions) [N/m] now, (3 n, 3 n), supports not regarded, as the arrays that
        scipy.sparse.csr_matrix takes: data, column indices and indptr. Molecule m has rows 3 m, 3 m + 1 and 3 m + 2."""
    def mass_matrix(self) -> tuple[Floats, Ints, Ints]:
        """The masses of the molecules [kg] on the diagonal, (3 n, 3 n), as tangent() has its matrix."""
    def stiffness(self) -> tuple[Floats, Ints, Ints]:
        """The stiffness -d(all forces)/d(positions) [N/m] now, supports not regarded: data (m, 3, 3), columns (m,) and
        row starts (n + 1,) of its blocks, what scipy.sparse.bsr_matrix takes; tangent() gives them as CSR."""
    def view(self) -> View:
        """The body as it is now in 3D: a View."""
    def to_vtu(self, path: Path) -> None:
        """Writes the present state as a VTU file: displacements [m], tensions of the connections [N], and of cells
        Green and Lagrange's strain and Cauchy's stress [Pa]."""
    def to_meshio(self) -> Any:
        """A meshio.Mesh of the present state, with the fields of to_vtu."""
    def to_pyvista(self) -> Any:
        """A pyvista.UnstructuredGrid of the present state, with the fields of to_vtu."""
    def animate(self, dt: float, frames: int, *, scale: float = 1.0, interval: float = 40,
                act: Callable[[Simulation], object] | None = None, **options: Any) -> Any:
        """Steps `frames` times by dt [s] and gives a matplotlib animation of it, displacements times `scale`,
        `interval` [ms] a frame; act(simulation), if given, is called before each step. Options go to
        Line3DCollection."""

class Result:
    """Result of one strategy on a scene; SI units."""
    @property
    def scene(self) -> str: ...
    @property
    def strategy(self) -> str: ...
    @property
    def outcome(self) -> Outcome:
        """'converged', or how it stopped: 'limit_reached', 'inverted', 'diverged', 'mechanism', 'interrupted';
        'unsuited': the strategy cannot run on this body."""
    @property
    def cause(self) -> str:
        """Why it did not converge; '' if it did."""
    @property
    def good(self) -> bool:
        """As the command's exit code 0: no failure, and all that the scene expects holds."""
    @property
    def measures(self) -> dict[str, float]:
        """Value by name, of the last load step, or of the time history of a run."""
    @property
    def units(self) -> dict[str, str]:
        """SI unit of each measure by name; '' of a ratio."""
    @property
    def gradients(self) -> dict[str, dict[str, float]]:
        """Derivatives by name of the measure and key of the scene, those of derivatives_by; SI units."""
    @property
    def spreads(self) -> dict[str, dict[str, float]]:
        """Where the scene states an uncertainty, by name of the measure its 'deviation', and by key the share of each
        number in the square of that."""
    @property
    def main(self) -> list[str]:
        """Names of the measures by which strategies are compared, the most telling first."""
    @property
    def errors(self) -> dict[str, float]:
        """By measure, against the material's target: relative, or the difference of a ratio; MEASURE_to_reference:
        relative to the scene's reference."""
    @property
    def curve(self) -> dict[str, Floats]:
        """Columns, one row a load step or frame: 'at' (part of the load, or time [s]) and every measure.
        pandas.DataFrame takes it as it is."""
    @property
    def positions(self) -> Floats:
        """Of the last state [m], (n, 3); (0, 3) where none was reached."""
    @property
    def tensions(self) -> Floats:
        """Of the last state [N], one a connection, pulling is positive."""
    @property
    def stiffness(self) -> Floats | None:
        """6 x 6 [Pa], xx yy zz yz xz xy, of the experiment `material`; else None."""
    @property
    def warnings(self) -> list[str]:
        """What makes it doubtful, a sentence each."""
    @property
    def notes(self) -> list[str]:
        """What was chosen, left out or repaired, as the command prints it: another strategy than the one that was
        named, what the grips hold, sets of a mesh."""
    @property
    def solver(self) -> str: ...
    @property
    def newton_iterations(self) -> int: ...
    @property
    def linear_iterations(self) -> int: ...
    @property
    def build_seconds(self) -> float: ...
    @property
    def solve_seconds(self) -> float: ...
    @property
    def body(self) -> Body: ...
    def __getitem__(self, measure: str) -> float: ...
    def get(self, measure: str, default: Any = None) -> Any:
        """The measure of this name, or `default` if it was not taken."""
    def plot(self, ax: Any = None, **options: Any) -> Any:
        """The body in its last state, its connections coloured by their tension. Options go to Line3DCollection."""
    def view(self) -> View:
        """The body in 3D with its states: a View. Where states were kept, all of them."""
    def plot_curve(self, x: str | None = None, y: str | None = None, ax: Any = None, **options: Any) -> Any:
        """One measure of the curve over another: by default the stress–strain curve, or another measure over the load
        or time."""
    @property
    def states(self) -> list[tuple[float, Floats]]:
        """Where the molecules were at rest and after each load step or frame: pairs (load factor or time [s], positions
        (n, 3) [m]); empty unless it was run with keep_states=True."""
    def animate(self, scale: float = 1.0, interval: float = 100, **options: Any) -> Any:
        """A matplotlib animation of the states that were kept, displacements times `scale`, `interval` [ms] a state; in
        a notebook HTML(animation.to_jshtml()) plays it. Options go to Line3DCollection."""
    def to_frame(self) -> Any:
        """The curve as a pandas DataFrame: a row a load step or frame, a column a measure, and `at`, the load factor or
        time [s]."""
    def to_vtu(self, path: Path) -> None:
        """Writes the last state as a VTU file, with displacements [m] and the tensions of the connections [N]. Where
        states were kept, also each of them, PATH-000.vtu …, and PATH.pvd with their load factors or times."""
    def to_meshio(self) -> Any:
        """A meshio.Mesh of the last state, with displacements and tensions."""
    def to_pyvista(self) -> Any:
        """A pyvista.UnstructuredGrid of the last state, with displacements and tensions."""

class Laboratory:
    """A scene, read, checked and built: the path of a file, a dict as its YAML would be, or a Body. In addition to a
    dict or a Body `experiment` (elastin.Tension(…)), `material` and all other keys of a scene may stand:
    contact={…}, loads=[…], time={…}. `set` changes keys, as the command's --set: {"material.youngs_modulus": 5e3,
    "experiment.force": "1 mN"}. With a Catalog, strategies of one's own may be named."""
    def __init__(self, scene: Scene, *, experiment: Experiment | Mapping[str, Any] | None = None,
                 material: Material | Mapping[str, Any] | None = None, set: Changes = None,
                 catalog: Catalog | None = None, **keys: Any) -> None: ...
    @property
    def name(self) -> str: ...
    @property
    def title(self) -> str: ...
    @property
    def body(self) -> Body: ...
    @property
    def material(self) -> Material: ...
    @property
    def strategy(self) -> str:
        """The scene's own."""
    @property
    def strategies(self) -> list[str]:
        """Those that the scene compares."""
    @property
    def references(self) -> list[dict[str, Any]]:
        """Values of the same problem from elsewhere: dicts of measure, value, unit, source."""
    @property
    def expectations(self) -> list[dict[str, Any]]:
        """Values that the scene says must come out: dicts as references, with the strategy."""
    @property
    def warnings(self) -> list[str]: ...
    def compute_reference(self, option: Literal["", "computed", "none"] = "", *,
                          progress: Callable[[str], object] | None = None) -> None:
        """Computes the reference of the scene as the command `compare` does: what its own problem comes to on finer and
        finer cells. '' does it where the scene says so, 'computed' in any case, 'none' not at all. Runs after it
        have errors to it."""
    def export(self, path: Path, to: str, strategy: str = "") -> None:
        """Writes the scene for another program, as `elastin export --to FORMAT` does: a file, or of an engine a folder
        with its constants. What a user must know of it goes to the logger "elastin"."""
    def exported(self, strategy: str = "") -> dict[str, Any]:
        """The body with the constants of a strategy, as `elastin export --to json` writes it: a dict of lists, SI
        units. "connections" have "a", "b", "rest_length" and "stiffness"; the keys are described in
        scenes/README.md."""
    def measure(self, step: Callable[[dict[str, Any]], Mapping[str, Any]]) -> Result:
        """Runs the experiment in a solver of one's own, with the constants of the scene's strategy: step(request) gets
        what an engine of `elastin compare --engine` reads, a dict, and gives what that prints: {"positions": (n, 3),
        …}. The Result is measured off it as a strategy's is; what step raises comes out."""
    def run(self, strategy: str = "", *, progress: Callable[[str], object] | None = None,
            keep_states: bool = False, derivatives_by: Sequence[str] = ()) -> Result:
        """Runs the experiment with a strategy by name ('calibrated:angles', 'lattice+volume'); '' takes the scene's
        own. progress(doing) is called before each load step or frame; what it raises ends the run. keep_states: the
        result has the positions of each load step or frame. derivatives_by: keys of numbers of the scene,
        'material.youngs_modulus', by which all measures at rest are differentiated. Numerical trouble is an outcome
        in the result."""
    def simulation(self, strategy: str = "", *, stepper: str | Stepper = "symplectic_euler", safety: float = 0.8,
                   max_substeps: int = 1000, stepper_parameters: Mapping[str, float] = ...,
                   parameters: Mapping[str, float] = ..., scheme: str | Stepper | None = None,
                   scheme_parameters: Mapping[str, float] | None = None) -> Simulation:
        """The scene's body at rest, or at time 0, with its strategy, loads, damping and contact, held by its experiment
        and loaded in full at once, to be stepped. scheme, scheme_parameters: former names of stepper,
        stepper_parameters."""

class View:
    """A body in 3D, which a notebook shows: drag turns it. `html` is a page that needs no other file."""
    html: str
    def __init__(self, html: str) -> None:
        """Initialize self. See help(type(self)) for accurate signature."""
    def to_html(self, path: Path) -> None:
        """Writes it as a page."""

class Identification(dict[str, Any]):
    """What `elastin identify --json` writes, a dict: "parameters" (name, value, unit, low, high), "correlation",
    "relative_rms", "warnings" and more, SI units. found["mu_1"] is the value of a number by its name. It shows
    itself as the command does, in a notebook with the fit."""
    def __init__(self, found: Mapping[str, Any], answers: Any, number: int) -> None:
        """Initialize self. See help(type(self)) for accurate signature."""
    @property
    def material(self) -> Material:
        """The material found, a Material."""
    @property
    def figure(self) -> str:
        """Each test with its fit, SVG."""
    @property
    def points(self) -> dict[str, Any]:
        """Every point with its fit, columns by name."""
    def to_html(self, path: Path) -> None:
        """Writes the page of `elastin identify --out`, of all strategies: tables, figures, intervals. It needs no other
        file."""

class Verdicts(list[dict[str, Any]]):
    """Results of scenes compared with what they expect: a list of dicts that shows itself as a table."""
    @property
    def passed(self) -> bool:
        """Whether nothing failed."""
    def to_frame(self) -> Any:
        """A pandas DataFrame, one row an expectation."""

class Comparison(list[Result]):
    """Results of one scene, a strategy each: a list that can be indexed by name, and shows itself as a table."""
    def __getitem__(self, key: Any) -> Any: ...
    @property
    def recommended(self) -> str:
        """The strategy that `elastin compare` recommends by these results; "" where none comes near enough."""
    @property
    def advice(self) -> str:
        """That strategy with its numbers in a sentence, or why none is recommended."""
    def to_html(self, path: Path) -> None:
        """Writes their page, as `elastin compare --out` does: advice, error against time, curves, the body in 3D,
        tables. It needs no other file."""
    def view(self) -> View:
        """The body in 3D with the states of all results: a View."""
    def to_frame(self) -> Any:
        """A pandas DataFrame, one row a strategy: its outcome, measures, errors (error_MEASURE) and seconds."""
    def plot_curves(self, x: str | None = None, y: str | None = None, ax: Any = None, **options: Any) -> Any:
        """The curves of all results in one picture; see Result.plot_curve."""
    def plot(self, measure: str | None = None, ax: Any = None) -> Any:
        """Error of a measure, by default the most telling one, against the seconds that it took."""

class Sweep(list[Result]):
    """Results of one scene, one for each combination of the values of its keys; sweep["effective_modulus"] gives a
    measure as an array, NaN where a row has none. `changes` has what each row has under the keys."""
    changes: list[dict[str, Any]]
    def __init__(self, changes: Iterable[dict[str, Any]], results: Iterable[Result]) -> None:
        """Initialize self. See help(type(self)) for accurate signature."""
    @property
    def key(self) -> str:
        """The first of the keys."""
    @property
    def values(self) -> list[Any]:
        """What each row has under the first key."""
    def __getitem__(self, key: Any) -> Any: ...
    def columns(self) -> dict[str, Any]:
        """A column for each key, then strategy, outcome, each measure that some row has, and seconds to build and to
        solve. pandas.DataFrame takes it as it is."""
    def plot(self, measure: str | None = None, ax: Any = None, **options: Any) -> Any:
        """A measure, by default the most telling one, over the values of the first key: a line for each strategy and
        each combination of the other keys. Options go to matplotlib's plot."""

def body(description: Mapping[str, Any] | str, material: Material | Mapping[str, Any] | str | None = None) -> Body:
    """A body as a scene has it under `body:`: elastin.body({"lattice": {"kind": "cubic", "molecules": [5, 5, 5],
    "spacing": 1e-3}}), a dict or its YAML. Every shape of the scenes is there, with the same keys and messages;
    files are named from the working directory. The material, or what `material` takes, gives it its mass, by default
    that with which the body is used. What makes results doubtful is a warning; how a file was read goes to the
    logger "elastin"."""
def step_all(simulations: Iterable[Simulation], dt: float, count: int = 1, *, check: bool = True,
             threads: int | None = None) -> list[StepResult]:
    """Brings many simulations forward by dt [s], `count` times, at the same time: each goes on in one thread at a time,
    of `threads`, by default one a core. Gives their last results in order, bitwise those of step(). One that fails
    stops, and raises StepError when the others are done, unless check=False. Ctrl-C ends all within a step."""
def order_in_space(positions: ArrayLike) -> Ints:
    """The order in which points (n, 3) lie along a curve that fills space, (n,): a large body whose molecules are
    numbered like this, positions[order], is passed over several times as fast as one numbered at random."""
def numbered_in_space(body: Body) -> tuple[Body, Ints, Ints]:
    """The body with its molecules in the order of order_in_space, and the number that each molecule (n,) and each
    connection (c,) had: what is known of the old body goes over by x[molecule_from]. Bodies of parts keep theirs."""
def of_labels(body: Body, labels: ArrayLike) -> tuple[Body, Ints]:
    """The body in parts, one for each label of its cells (k,), whole numbers as a mesh's cell_data has them, and the
    number that each molecule had (n,). Simulation then takes a material for each label, ascending: Simulation(body,
    'neo_hookean', [fat, muscle]). Cells of a material that states another law than the first one have that law, all
    others the strategy. Molecules that labels share are the lowest one's, and have its density where the materials
    say it."""
def of_parts(parts: Sequence[tuple[str, Body, int]],
             ties: Sequence[tuple[str, str, float, float]] = ...) -> Body:
    """A body of several parts: (name, body, number of its material from 0; below 0: bone, which stays where it is
    unless something moves it) each. ties: (first, second, within [m], stiffness [Pa]): where two parts are near to
    each other, molecules in one place become one and others are tied to the surface."""
def material(description: Mapping[str, Any] | str) -> Material:
    """A material as a scene has it under `material:`: elastin.material({"law": "ogden", "terms": [[6.3e5, 1.3]],
    "bulk_modulus": 1e9, "relaxation": {"terms": [[0.5, 1.0]]}}), a dict or its YAML, with the same keys and
    messages: laws, curves, fibres, muscle, relaxation, softening. Plain numbers are SI; files are named from the
    working directory."""
    ...

def lattice(molecules: Sequence[int], spacing: float | Sequence[float],
            connections: Sequence[Literal["axis", "face", "space"]] = ("axis", "face"), *, radius: float | None = None,
            density: float = 1000.0) -> Body:
    """A cubic lattice of (nx, ny, nz) molecules, `spacing` [m] apart (a number, or one along x, y and z), joined along
    "axis", "face" and "space" diagonals. radius [m], by default half the shortest connection; density [kg/m^3], by
    default that of the material with which the body is used."""
def read_mesh(path: Path, length_unit: Literal["m", "cm", "mm", "um", "nm"], *, radius: float | None = None,
              density: float = 1000.0, thickness: float = 0.0) -> Body:
    """The body of a mesh file, of any kind that body.mesh of a scene reads, whose numbers are in length_unit "m", "cm",
    "mm", "um" or "nm"; triangles have a thickness [m]. radius and density as for lattice."""
def law(name: str, energy: Callable[..., Any], *, summary: str = "", source: str = "",
        membrane: bool = False) -> Strategy:
    """A cell law of one's own for compare, run and Simulation, from its energy density W [J/m^3]:

        elastin.law("mine", lambda I1, J, mu, lam: mu / 2 * (I1 - 3) - mu * numpy.log(J) + lam / 2 * (J - 1)**2)

    The names of the function's arguments determine their meaning: of the right Cauchy-Green tensor C the invariants
    I1 = tr C, I2, I3 = J^2, J and those of J^(-2/3) C, I1_bar and I2_bar, all at the rest values 3, 3, 1; of fibres
    along a unit vector a at rest I4 = a.Ca, I5 = a.CCa, I4_bar and I5_bar, 1 at rest; of the material E, nu, mu, lam
    and kappa [Pa]. Every other argument is a parameter that a scene may set and has a default, a number or a
    Parameter. A law of solids is a material's, too, and then has its constants and the direction a from there:
    {"law": mine, "k": 3e4, "direction": [0, 0, 1]}, in scenes by its name; E and nu follow, unless W takes them, and
    identify() finds the constants. The function is called once, with values that record what it computes by + - * /
    **, numpy's functions and elastin.where; slopes and second slopes follow by the rules of differentiation, so they
    are exact, and run in C++. With membrane=True it is a law of membranes, which thin so that there is no stress
    across. Raises InputError where W has a stress at rest, or is unstable there, as soon as the law meets a
    material."""
def load(name: str, forces: Callable[..., ArrayLike], energy: Callable[..., float] | None = None, *,
         summary: str = "", source: str = "") -> Load:
    """A load of one's own for Simulation.add_load and scenes, from a function of the forces [N] on all molecules, (n,
    3):

        elastin.load("trap", lambda positions, stiffness=1e-3: -stiffness * (positions - middle))
        elastin.load("wind", lambda velocities, time, drag=1e-6: drag * (wind(time) - velocities))

    The names of its arguments determine their meaning: positions [m] and velocities [m/s], (n, 3), time [s], the
    body. Every other argument is a parameter with a default, a number or a Parameter, that add_load(trap,
    stiffness=2e-3) and a scene, loads=[{"trap": {"stiffness": 2e-3}}], set. `energy`, a function of the same
    arguments, is the potential energy [J], where the forces have one: equilibria then minimise it. Newton's method
    takes how the force on each molecule changes with its own position and velocity, by differences; forces between
    molecules cost it more iterations. What a function raises ends the step or run, and comes out. A scene takes the
    load as it is, loads=[trap], or by its name from a Catalog."""
def stepper(name: str, step: Callable[..., tuple[ArrayLike, ArrayLike]], *, explicit: bool = True, order: int = 1,
            summary: str = "", source: str = "") -> Stepper:
    """A stepper of one's own, Simulation(…, stepper=it), from a function that gives positions and velocities, (n, 3)
    each, at the end of a step by dt [s]:

        def leap(positions, velocities, forces, masses, dt):
            velocities = velocities + dt * forces(positions, velocities) / masses[:, None]
            return positions + dt * velocities, velocities

    The names of its arguments determine their meaning: positions [m] and velocities [m/s] at the beginning, masses
    (n,) [kg], dt, time [s], the body, and forces, a function of positions and velocities that gives all forces [N]
    but those of supports, as they act at the end of the step. Other arguments are parameters with a default
    (stepper_parameters). Fixed and moved molecules then go where their supports want them; a step that is not
    finite, or inverts a cell, fails and leaves the state as it was. explicit: whether steps must stay below the
    body's longest stable one, and are divided. order: of the error at a fixed time."""
def where(condition: Any, one: Any, other: Any) -> Any:
    """In an energy of elastin.law: `one` where the condition holds (J < 1), else `other`. Elsewhere as numpy.where."""
def run(scene: Scene, strategy: str | Strategy = "", *, experiment: Experiment | Mapping[str, Any] | None = None,
        material: Material | Mapping[str, Any] | None = None, reference: Literal["", "computed", "none"] = "none",
        set: Changes = None, catalog: Catalog | None = None, progress: Progress = None,
        keep_states: bool = False, derivatives_by: Sequence[str] = (), **keys: Any) -> Result:
    """Runs a scene with a strategy (a name, or a Strategy; "" is the scene's own) and gives its Result. The scene is a
    file, a dict or a Body, with further keys, as for Laboratory. Numbers equal those of the command to the last bit.
    progress: a function that is called with what is being done, or True for a line that says it. reference:
    "computed" first computes the values that errors refer to; keep_states: the result has the positions of every
    load step or frame; derivatives_by: the result's gradients are by these keys."""
def compare(scene: Scene, strategies: str | Strategy | Sequence[str | Strategy] | None = None, *,
            experiment: Experiment | Mapping[str, Any] | None = None,
            material: Material | Mapping[str, Any] | None = None, reference: Literal["", "computed", "none"] = "",
            set: Changes = None, catalog: Catalog | None = None, progress: Progress = None,
            **keys: Any) -> Comparison:
    """Runs a scene (a file, a dict or a Body, as for Laboratory) with several strategies: names and strategies of one's
    own; by default those that it compares itself, of a Body all. Where the scene says so, or nothing else shows what
    is right, its reference is computed first, as the command does: reference="none" leaves that out, "computed" does
    it in any case."""
def export(scene: Scene, path: Path, to: str, strategy: str = "", *,
           experiment: Experiment | Mapping[str, Any] | None = None,
           material: Material | Mapping[str, Any] | None = None, set: Changes = None,
           catalog: Catalog | None = None, **keys: Any) -> None:
    """Writes a scene for another program, see Laboratory.export."""
def measure(step: Callable[[dict[str, Any]], Mapping[str, Any]], scene: Scene,
            experiment: Experiment | Mapping[str, Any] | None = None, *,
            material: Material | Mapping[str, Any] | None = None, set: Changes = None, catalog: Catalog | None = None,
            **keys: Any) -> Result:
    """Measures a solver of one's own, see Laboratory.measure: step(request) solves, the scene is a Body, a dict or a
    file, further keys are as for Laboratory, stiffness="lattice" and engines={"dt": "1 ms"} among them."""
def verify(scene: Scene | Sequence[Scene], *, experiment: Experiment | Mapping[str, Any] | None = None,
           material: Material | Mapping[str, Any] | None = None, set: Changes = None, catalog: Catalog | None = None,
           progress: Progress = None, **keys: Any) -> Verdicts:
    """Compares a scene, or each of a list, with what it expects: Verdicts, a dict a run with "scene", "strategy",
    "verdict" ("passed", "failed" or "not judged"), "outcome", "cause", "measures", "seconds" and "expectations"."""
def sweep(scene: Scene, key: str | Mapping[str, Iterable[Any]], values: Iterable[Any] | None = None, *,
          strategy: str | Strategy | Sequence[str | Strategy] = "", set: Changes = None,
          catalog: Catalog | None = None, progress: Progress = None, client: Any = None,
          **keys: Any) -> Sweep:
    """Runs a scene once for each value of one of its keys, sweep(scene, "material.poissons_ratio", [0.1, 0.2, 0.3]), or
    for each combination of the values of several, the last key fastest: sweep(scene, {"body.lattice.molecules": [[5,
    5, 5], [9, 9, 9]], "material.poissons_ratio": [0.1, 0.2]}). `strategy` may be a list: each of them runs in every
    combination. `set` and what else `run` takes hold for all rows.

    With a `client` its workers compute the rows: a dask.distributed.Client, or an executor of concurrent.futures.
    The rows are the same to the last bit but for times. A scene file must be there under the same path for all
    workers. Of a dask.distributed.Client a row whose worker dies goes to another one. `progress` is called with what
    a row is doing, or with a client how many rows are there."""
def gradient(scene: Scene, of: Sequence[str] | None = None, by: Sequence[str] = (), strategy: str | Strategy = "",
             **options: Any) -> Floats:
    """Derivatives of measures by numbers of a scene, as an array (measures, numbers) in SI units, by one linear solve a
    number at each equilibrium. of: names of measures, by default all, in the order of the result's; by: keys of the
    scene that state numbers, ["material.youngs_modulus", "loads.0.pressure"]. Scene and options are as for run.
    Experiments in time, friction and other histories raise InputError."""
def identify(scene: Scene | None = None, data: Mapping[str, Any] | None = None, *,
             material: Material | Mapping[str, Any] | None = None, tests: Sequence[str] = (),
             laws: Sequence[str] = (), strategies: Sequence[str] = (), set: Changes = None,
             catalog: Catalog | None = None, progress: Progress = None, **keys: Any) -> Any:
    """Fits a material to measured tests and gives an Identification, of several `strategies` of the specimens a list.

        elastin.identify(data={"uniaxial": {"stretch": stretch, "nominal_stress": stress}},
                         material={"law": "ogden", "terms": [[1e5, 2]]})

    The scene is a file, a dict or a Body, as for Laboratory, with an `identify` section whose tests are files, or
    columns of arrays by name, {"kind": "uniaxial", "stretch": …, "nominal_stress": …}; SI units, unless a name has
    another, "force [kN]". Without a scene the tests are those of `data` by their kind, each with its keys and
    columns, and identify={"fixed": ["bulk_modulus"]} has the section's other keys. With one `data` has what replaces
    the data of its tests, {test: path or columns}. Of `tests` alone are fitted, the others predicted; `laws` are
    compared (["all"]); a law of one's own, elastin.law, is named where the material has its constants,
    material={"law": mine, "k": 3e4}. A Catalog brings strategies of one's own. progress: True shows a line, a
    function is called with what is being done."""
def strategies(catalog: Catalog | None = None) -> list[Strategy]:
    """Every strategy there is, with summary, source and parameters."""
def steppers() -> list[Row]:
    """What a simulation takes as its stepper."""
def linear_solvers() -> list[Row]:
    """What scenes name under solver.linear_solver."""
def loads() -> list[Row]:
    """What Simulation.add_load takes, and scenes under loads."""
def material_laws() -> list[Row]:
    """What Material takes as its law."""
def measures() -> list[tuple[str, str, str]]:
    """Every measure that an experiment can take: (name, SI unit, description)."""
def set_threads(threads: int) -> None:
    """How many threads loops over large bodies take; 0 = one a core. Results are bitwise identical with any."""
def threads() -> int:
    """How many threads loops over large bodies take."""
def experiments() -> list[type[Experiment]]:
    """Every kind of experiment, a class each."""

class Experiment:
    """What is done to a body, and what is read: an experiment of the scenes with its keys. Quantities are plain numbers
    in SI units or text with a unit, "3 mm". Where the ends have grips, `grips` sets both.

    A class of one's own is an experiment at rest with measures of its own:

        class Squeeze(elastin.Experiment):
            measures = {"force": "N", "bulge": "m"}                    # by name their SI unit, the most telling first
            def __init__(self, depth):
                self.depth = depth
            def hold(self, body):                                      # who is held, and where it goes [m]
                return [(bottom, (0, 0, 0)), (top, (0, 0, -self.depth), "xy")]
            def measure(self, body, positions, reactions):             # (n, 3) [m] and [N]
                return {"force": reactions[bottom, 2].sum(), "bulge": numpy.ptp(positions[:, 0])}

    `hold` gives triples of molecules, a displacement (3,) or (k, 3), and directions that stay free, "xy" or a
    projector, if any; `forces(body)`, if it is there, forces on all molecules (n, 3) [N]; `load_steps` is the number
    of steps in which both grow. What either raises ends the run, and comes out."""
    kind: str
    in_time: bool
    table: dict[str, dict[str, str]]
    given: dict[str, Any]
    measures: Mapping[str, str]
    load_steps: int
    def forces(self, specimen: Body) -> ArrayLike | None:
        """Of an experiment of one's own: forces on all molecules (n, 3) [N], or None."""
    def __init__(self, **keys: Any) -> None:
        """Initialize self. See help(type(self)) for accurate signature."""
    @classmethod
    def allowed(cls) -> list[str]:
        """The names of its keys."""
    def keys(self) -> dict[str, Any]:
        """As a scene has it: a dict with `kind`."""

# --- experiments: made from the table of scenes by tools/stubs; below nothing is kept ---

class Tension(Experiment):
    """A bar is pulled along its axis: effective modulus, Poisson's ratio, stress–strain curve.
    axis: axis of the bar, from the fixed end to the loaded one; `longest`: the principal axis of inertia along which
    the body extends furthest (direction, or longest; default: z).
    force [N]: force on the loaded end; not 0 (quantity; default: one of four needed).
    displacement [m]: displacement of the loaded end; not 0 (quantity; default: one of four needed).
    strain: that displacement over the distance of the end layers; not 0 (number; default: one of four needed).
    gravity [m/s^2]: acceleration by which the body's own weight is the load: under tension it hangs from its fixed
    end, under compression it stands on it; not 0 (quantity; default: one of four needed).
    fixed_grip: whether the end is also fixed sideways (clamped, sliding; default: sliding).
    loaded_grip: whether the end is also fixed sideways (clamped, sliding; default: sliding).
    load_sharing: how the molecules of the loaded end share a force: by tributary areas, or equally (area, molecules;
    default: area).
    reading: elongation of the loaded end, or of one corner molecule (mean, corner; default: mean).
    cross_section [m^2]: section A that carries the load (quantity; default: volume over length of the cells, between
    the planes of gauge if there are any; without cells the hull of the molecules along the axis).
    gauge_length [m]: length l₀ to which the strain refers (quantity; default: between the end layers).
    gauge [m]: planes, measured from the fixed end, between which an extensometer reads (two quantities; default:
    none).
    fixed: molecules that are held in place of the fixed end (list of molecules, or [pick](#picked-molecules);
    default: the end).
    loaded: molecules that are held in place of the loaded end (list of molecules, or [pick](#picked-molecules);
    default: the end).
    grip_depth [m]: molecules that are so near to the furthest one of an end, or to the furthest voxel of an image,
    belong to it (quantity; default: the whole end: its plane, or, where it is rough or tilted, the sides of the
    cells that look outward).
    load_steps: equal steps in which the load grows (whole; default: 1).
    cycle: parts of the load that are reached one after the other, each in `load_steps`: [1, 0, 1] (list of numbers;
    default: [1])."""
    def __init__(self, *, axis: Any = None, force: Any = None, displacement: Any = None, strain: Any = None, gravity:
                 Any = None, fixed_grip: Any = None, loaded_grip: Any = None, load_sharing: Any = None, reading: Any =
                 None, cross_section: Any = None, gauge_length: Any = None, gauge: Any = None, fixed: Any = None,
                 loaded: Any = None, grip_depth: Any = None, load_steps: Any = None, cycle: Any = None, grips: Any =
                 None) -> None: ...

class Compression(Experiment):
    """A bar is pressed along its axis and measured as in tension.
    The keys are those of Tension."""
    def __init__(self, *, axis: Any = None, force: Any = None, displacement: Any = None, strain: Any = None, gravity:
                 Any = None, fixed_grip: Any = None, loaded_grip: Any = None, load_sharing: Any = None, reading: Any =
                 None, cross_section: Any = None, gauge_length: Any = None, gauge: Any = None, fixed: Any = None,
                 loaded: Any = None, grip_depth: Any = None, load_steps: Any = None, cycle: Any = None, grips: Any =
                 None) -> None: ...

class Biaxial(Experiment):
    """A block or sheet is stretched along two directions between smooth grips, free along the third. [Timoshenko &
    Goodier 1970, section 6]
    axis: first direction, in which the body is stretched (direction; default: x).
    across: second direction, perpendicular to it (direction; default: y).
    strain: nominal strain along both, or along each; the first is not 0 (number, or two numbers; default: needed).
    grip_depth [m]: molecules that are so near to the furthest one of an end, or to the furthest voxel of an image,
    belong to it (quantity; default: the whole end: its plane, or, where it is rough or tilted, the sides of the
    cells that look outward).
    load_steps: equal steps in which the load grows (whole; default: 1)."""
    def __init__(self, *, axis: Any = None, across: Any = None, strain: Any = None, grip_depth: Any = None, load_steps:
                 Any = None) -> None: ...

class Planar(Experiment):
    """A block or sheet is stretched along one direction and keeps its width along another: pure shear. [Timoshenko &
    Goodier 1970, section 6]
    axis: first direction, in which the body is stretched (direction; default: x).
    across: second direction, perpendicular to it (direction; default: y).
    strain: nominal strain along `axis`; not 0 (number; default: needed).
    grip_depth [m]: molecules that are so near to the furthest one of an end, or to the furthest voxel of an image,
    belong to it (quantity; default: the whole end: its plane, or, where it is rough or tilted, the sides of the
    cells that look outward).
    load_steps: equal steps in which the load grows (whole; default: 1)."""
    def __init__(self, *, axis: Any = None, across: Any = None, strain: Any = None, grip_depth: Any = None, load_steps:
                 Any = None) -> None: ...

class Shear(Experiment):
    """Planes across the axis slide along a direction, at constant height: shear modulus.
    axis: axis of the body, from the fixed end to the loaded one; `longest`: the principal axis of inertia along
    which the body extends furthest (direction, or longest; default: z).
    direction: direction of the displacement, perpendicular to `axis`; of `axis: longest` the part that is counts
    (direction; default: needed).
    displacement [m]: displacement of the loaded end; not 0 (quantity; default: one of three needed).
    strain: displacement over height; not 0 (number; default: one of three needed).
    angle: angle of shear; not 0 (angle; default: one of three needed).
    sides: whether two rigid plates carry the shear, or the whole surface follows it (free, affine; default: free).
    cross_section [m^2]: section A that carries the load (quantity; default: volume over length of the cells, between
    the planes of gauge if there are any; without cells the hull of the molecules along the axis).
    fixed: molecules that are held in place of the fixed end (list of molecules, or [pick](#picked-molecules);
    default: the end).
    loaded: molecules that are held in place of the loaded end (list of molecules, or [pick](#picked-molecules);
    default: the end).
    grip_depth [m]: molecules that are so near to the furthest one of an end, or to the furthest voxel of an image,
    belong to it (quantity; default: the whole end: its plane, or, where it is rough or tilted, the sides of the
    cells that look outward).
    load_steps: equal steps in which the load grows (whole; default: 1)."""
    def __init__(self, *, axis: Any = None, direction: Any = None, displacement: Any = None, strain: Any = None, angle:
                 Any = None, sides: Any = None, cross_section: Any = None, fixed: Any = None, loaded: Any = None,
                 grip_depth: Any = None, load_steps: Any = None) -> None: ...

class Torsion(Experiment):
    """One end of a clamped bar is turned about its axis at constant height: torque, shear modulus of a rectangle.
    [Timoshenko & Goodier 1970, section 109]
    axis: axis of the body, from the fixed end to the loaded one; `longest`: the principal axis of inertia along
    which the body extends furthest (direction, or longest; default: z).
    angle: rotation of the turned end; not 0 (angle; default: needed).
    fixed: molecules that are held in place of the fixed end (list of molecules, or [pick](#picked-molecules);
    default: the end).
    loaded: molecules that are held in place of the loaded end (list of molecules, or [pick](#picked-molecules);
    default: the end).
    grip_depth [m]: molecules that are so near to the furthest one of an end, or to the furthest voxel of an image,
    belong to it (quantity; default: the whole end: its plane, or, where it is rough or tilted, the sides of the
    cells that look outward).
    load_steps: equal steps in which the load grows (whole; default: 1)."""
    def __init__(self, *, axis: Any = None, angle: Any = None, fixed: Any = None, loaded: Any = None, grip_depth: Any =
                 None, load_steps: Any = None) -> None: ...

class Hydrostatic(Experiment):
    """Equal strain along all directions: bulk modulus.
    strain: strain of each side; negative compresses; not 0 (number; default: needed).
    sides: whether six smooth walls carry the strain, or the whole surface follows it (sliding, affine; default:
    sliding).
    grip_depth [m]: molecules that are so near to the furthest one of an end, or to the furthest voxel of an image,
    belong to it (quantity; default: the whole end: its plane, or, where it is rough or tilted, the sides of the
    cells that look outward).
    load_steps: equal steps in which the load grows (whole; default: 1)."""
    def __init__(self, *, strain: Any = None, sides: Any = None, grip_depth: Any = None, load_steps: Any =
                 None) -> None: ...

class Bending(Experiment):
    """A cantilever bends under its own weight or a force on its tip: effective modulus, deflection. [Timoshenko 1921,
    Cowper 1966]
    axis: from the clamped root to the tip; `longest`: the principal axis of inertia along which the body extends
    furthest (direction, or longest; default: x).
    direction: direction of the load, perpendicular to `axis`; of `axis: longest` the part that is counts (direction;
    default: needed).
    gravity [m/s^2]: acceleration that gives the weight; not 0 (quantity; default: this, force or both).
    force [N]: force on the tip; not 0 (quantity; default: this, gravity or both).
    fixed: molecules that are held in place of the fixed end (list of molecules, or [pick](#picked-molecules);
    default: the end).
    loaded: molecules that are held in place of the loaded end (list of molecules, or [pick](#picked-molecules);
    default: the end).
    grip_depth [m]: molecules that are so near to the furthest one of an end, or to the furthest voxel of an image,
    belong to it (quantity; default: the whole end: its plane, or, where it is rough or tilted, the sides of the
    cells that look outward).
    load_steps: equal steps in which the load grows (whole; default: 1)."""
    def __init__(self, *, axis: Any = None, direction: Any = None, gravity: Any = None, force: Any = None, fixed: Any =
                 None, loaded: Any = None, grip_depth: Any = None, load_steps: Any = None) -> None: ...

class Inflation(Experiment):
    """A closed membrane is inflated by pressure, by volume or by gas: radius, wall stress.
    pressure [Pa]: pressure inside over that outside; not 0 (quantity; default: one of three needed).
    volume_ratio: enclosed volume over that at rest (number; default: one of three needed).
    gas: gas that is let in; its keys stand below (map; default: one of three needed).
    symmetry: normals of planes through the origin that cut the body, each perpendicular to the others (list of
    directions; default: none).
    load_steps: equal steps in which the load grows (whole; default: 1)."""
    def __init__(self, *, pressure: Any = None, volume_ratio: Any = None, gas: Any = None, symmetry: Any = None,
                 load_steps: Any = None) -> None: ...

class MaterialExperiment(Experiment):
    """Six small strains of the surface: the body's 6 × 6 stiffness matrix and its isotropic means.
    grip_depth [m]: molecules that are so near to the furthest one of an end, or to the furthest voxel of an image,
    belong to it (quantity; default: the whole end: its plane, or, where it is rough or tilted, the sides of the
    cells that look outward)."""
    def __init__(self, *, grip_depth: Any = None) -> None: ...

class Bubble(Experiment):
    """A flat disc, fixed at its rim, is inflated from one side: height, stretch and stress at the pole. [[TP], eqs
    18-25]
    pressure [Pa]: the pressure that `load_steps` reach, or one pressure for each step, ascending (quantity, or list;
    default: this, or measured).
    measured [Pa, m]: `[pressure, height]`, ascending; a file has one pair in each line, with units (list of pairs,
    or file in the scene's folder; default: this, or pressure).
    load_steps: equal steps in which the load grows (whole; default: 1).
    identify.degree: finds the secant modulus E(ε) from the measured heights: degree of the polynomial (whole;
    default: 2).
    identify.up_to: strain up to which it counts (number; default: 1.5 × the cap's strain)."""
    def __init__(self, *, pressure: Any = None, measured: Any = None, load_steps: Any = None, identify: Any =
                 None) -> None: ...

class Indentation(Experiment):
    """A rigid indenter is pressed into a body that stands on its far end: force, indentation modulus; needs `contact`.
    [Johnson 1985, ch. 3, 4]
    axis: direction of the motion (direction; default: -z).
    indenter: what is pressed into the body (map, or an obstacle's name; default: needed).
    indenter.sphere.radius [m]: radius of a sphere (quantity; default: this, or flat).
    indenter.flat.radius [m]: radius of a flat punch (quantity; default: this, or sphere).
    depth [m]: depth from the first contact point (quantity; default: one of three needed).
    strain: `depth` over the height along the axis of the body, of all bodies together (number; default: one of three
    needed).
    force [N]: force, of the whole body, that ends the motion; not of an obstacle (quantity; default: one of three
    needed).
    at [m]: a position on the indenter's axis; not of an obstacle (vector; default: the middle).
    bottom: how the far end is fixed (clamped, sliding; default: clamped).
    fixed: molecules that are held in place of the far end (list of molecules, or [pick](#picked-molecules); default:
    the end).
    grip_depth [m]: molecules that are so near to the furthest one of an end, or to the furthest voxel of an image,
    belong to it (quantity; default: the whole end: its plane, or, where it is rough or tilted, the sides of the
    cells that look outward).
    symmetry: normals of planes through the origin that cut the body, each perpendicular to the others (list of
    directions; default: none).
    load_steps: equal steps in which the load grows (whole; default: 1)."""
    def __init__(self, *, axis: Any = None, indenter: Any = None, depth: Any = None, strain: Any = None, force: Any =
                 None, at: Any = None, bottom: Any = None, fixed: Any = None, grip_depth: Any = None, symmetry: Any =
                 None, load_steps: Any = None) -> None: ...

class Press(Experiment):
    """A body, or the near end of one, is pressed onto what lies before it: force, contact area; needs `contact`.
    axis: direction of the motion (direction; default: -z).
    displacement [m]: displacement of what is moved (quantity; default: one of three needed).
    strain: `displacement` over the height along the axis of the body, of all bodies together (number; default: one
    of three needed).
    force [N]: force that ends the motion, with that of a preload (quantity; default: one of three needed).
    move: what is moved (a body's name, or [pick](#picked-molecules); default: the near end).
    fix: what is fixed (a body's name, or [pick](#picked-molecules); default: the far end, or rigid bodies).
    grip: how both are fixed across the axis (clamped, sliding; default: clamped).
    grip_depth [m]: molecules that are so near to the furthest one of an end, or to the furthest voxel of an image,
    belong to it (quantity; default: the whole end: its plane, or, where it is rough or tilted, the sides of the
    cells that look outward).
    load_steps: equal steps in which the load grows (whole; default: 1)."""
    def __init__(self, *, axis: Any = None, displacement: Any = None, strain: Any = None, force: Any = None, move: Any =
                 None, fix: Any = None, grip: Any = None, grip_depth: Any = None, load_steps: Any = None) -> None: ...

class Sliding(Experiment):
    """A body lies on a plane that is tilted, or slides along it: friction, slip angle; needs `contact`.
    up: normal of the plane (direction; default: z).
    along: direction down the slope, perpendicular to `up` (direction; default: x).
    gravity [m/s^2]: acceleration of the weight (quantity; default: 9.81).
    floor: what the body stands on (an obstacle's name; default: a plane of its own).
    incline.angle: constant slope (angle; default: one of three needed).
    sled.speed [m/s]: initial speed along a level floor (quantity; default: one of three needed).
    threshold.from: slope at time 0, which grows (angle; default: one of three needed).
    threshold.rate [1/s]: rate at which the slope grows (quantity; default: needed with from)."""
    def __init__(self, *, up: Any = None, along: Any = None, gravity: Any = None, floor: Any = None, incline: Any =
                 None, sled: Any = None, threshold: Any = None) -> None: ...

class Loads(Experiment):
    """The scene's own `loads` and `supports` grow together: displacements, reactions of named sets.
    read: sets that are measured: for the name `top`, `top_displacement` (the largest), `top_x` (the mean) and
    `top_reaction_x` (the sum), and so along y and z; with `around` `top_turn` [rad] and the stresses
    `top_radius_stress`, `top_circumference_stress`, `top_axis_stress` (list of maps; default: none).
    read.name: letters, digits and _: the measures begin with it (text; default: needed).
    read.molecules: whose displacements and supports' forces are measured (list of molecules, or
    [pick](#picked-molecules); default: needed).
    read.around.axis: axis around which directions turn: the mean stresses of the set's cells are along radius,
    circumference and axis (direction; default: needed).
    read.around.through [m]: a point of the axis (vector; default: 0).
    moved: molecules that are moved, in addition to `supports`; an item adds its directions to those of the items
    before it, and a rigid body moves as a whole; `release` frees those with a displacement (list of maps; default:
    none).
    moved.molecules: which molecules are moved (list of molecules, or [pick](#picked-molecules); default: needed).
    moved.displacement [m]: their displacement (vector; default: needed).
    moved.fix: perpendicular directions along which the displacement is prescribed; they are free along the others
    (list of directions, or all; default: all).
    load_steps: equal steps in which the load grows (whole; default: 1)."""
    def __init__(self, *, read: Any = None, moved: Any = None, load_steps: Any = None) -> None: ...

class Motion(Experiment):
    """A body, free or fixed and loaded by a fixture, is observed as it moves.
    fixture: how the body is fixed and loaded (experiment at rest; default: free body).
    in_time: factor of the fixture's load (time function; default: constant)."""
    def __init__(self, *, fixture: Any = None, in_time: Any = None) -> None: ...

class Release(Experiment):
    """A loaded body is released, or loaded at once: free vibration, its frequency and damping.
    fixture: how the body is fixed, and loaded before it is released (experiment at rest; default: needed).
    load: whether the load is taken away at time 0, or put on at once (removed, applied; default: removed)."""
    def __init__(self, *, fixture: Any = None, load: Any = None) -> None: ...

class Creep(Experiment):
    """A force is applied and stays: displacement over time, retardation time.
    fixture: how the body is fixed, with the force that stays (experiment at rest; default: needed)."""
    def __init__(self, *, fixture: Any = None) -> None: ...

class Relaxation(Experiment):
    """A displacement grows and stays: force over time, relaxation time.
    fixture: how the body is fixed, with the displacement that stays (experiment at rest; default: needed).
    ramp [s]: time in which the displacement grows (quantity; default: needed)."""
    def __init__(self, *, fixture: Any = None, ramp: Any = None) -> None: ...

class Cyclic(Experiment):
    """A displacement oscillates: storage and loss modulus over the last period.
    fixture: how the body is fixed, with the displacement that is the amplitude (experiment at rest; default:
    needed).
    frequency [1/s]: frequency of the oscillation (quantity; default: needed)."""
    def __init__(self, *, fixture: Any = None, frequency: Any = None) -> None: ...

class Shake(Experiment):
    """The clamped end of a body oscillates: amplitude ratio and phase of the far end.
    axis: from the clamped end to the far one; `longest`: the principal axis of inertia along which the body extends
    furthest (direction, or longest; default: x).
    direction: direction of the oscillation (direction; default: axis).
    amplitude [m]: amplitude of the clamped end (quantity; default: this, or strain).
    strain: `amplitude` over the height along the axis of the body, of all bodies together (number; default: this, or
    amplitude).
    frequency [1/s]: frequency of the oscillation (quantity; default: needed).
    fixed: molecules that are held in place of the fixed end (list of molecules, or [pick](#picked-molecules);
    default: the end).
    loaded: molecules that are held in place of the loaded end (list of molecules, or [pick](#picked-molecules);
    default: the end).
    grip_depth [m]: molecules that are so near to the furthest one of an end, or to the furthest voxel of an image,
    belong to it (quantity; default: the whole end: its plane, or, where it is rough or tilted, the sides of the
    cells that look outward)."""
    def __init__(self, *, axis: Any = None, direction: Any = None, amplitude: Any = None, strain: Any = None, frequency:
                 Any = None, fixed: Any = None, loaded: Any = None, grip_depth: Any = None) -> None: ...

class Drop(Experiment):
    """A free body falls on a floor, or on the scene's obstacles: restitution, duration of contact.
    direction: direction of the fall (direction; default: -z).
    gravity [m/s^2]: acceleration of the fall (quantity; default: 0).
    height [m]: height of the lowest sphere above the floor; not with `contact` (quantity; default: 0).
    speed [m/s]: speed along `direction` at time 0 (quantity; default: 0).
    stiffness [N/m]: stiffness of the floor for each molecule; not with `contact` (quantity; default: E × mean
    diameter).
    damping [N s/m]: damping of the floor; not with `contact` (quantity; default: 0)."""
    def __init__(self, *, direction: Any = None, gravity: Any = None, height: Any = None, speed: Any = None, stiffness:
                 Any = None, damping: Any = None) -> None: ...

class Parachute(Experiment):
    """A canopy with a load on `lines` falls through air: how it opens, largest force in a line.
    direction: direction of the fall (direction; default: -z).
    gravity [m/s^2]: acceleration of the fall (quantity; default: 9.81).
    speed [m/s]: speed along `direction` at time 0 (quantity; default: 0)."""
    def __init__(self, *, direction: Any = None, gravity: Any = None, speed: Any = None) -> None: ...

class Vibration(Experiment):
    """Natural frequencies and shapes of a body, free or fixed by a fixture; at rest.
    fixture: how the body is fixed (experiment at rest; default: free body).
    load: whether the body vibrates about rest, or about its equilibrium under the fixture's load (removed, applied;
    default: removed).
    count: number of frequencies (whole; default: 6)."""
    def __init__(self, *, fixture: Any = None, load: Any = None, count: Any = None) -> None: ...
