"""Films of people from pedestrian trajectories, by the program ``populace``.

>>> import populace
>>> film = populace.render(trajectory, fps=25, area=walkable_area)  # doctest: +SKIP
>>> film.path, film.measures["position_error"]  # doctest: +SKIP

``python -m populace`` passes its arguments to the program.
"""

from populace._program import Error, ProgramNotFound, program
from populace._render import Rendering, render

__all__ = ["Error", "ProgramNotFound", "Rendering", "program", "render"]
