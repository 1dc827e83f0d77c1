from squeezefilm.api.film import Film as Film
from squeezefilm.api.forces import Force as Force
from squeezefilm.api.models import Fit as Fit
from squeezefilm.api.models import Study as Study
from squeezefilm.api.models import load as load
from squeezefilm.errors import InputError as InputError
from squeezefilm.errors import RunError as RunError
from squeezefilm.film.scene import Scene as Scene

__version__: str
__all__ = ["Film", "Fit", "Force", "InputError", "RunError", "Scene", "Study", "load"]
