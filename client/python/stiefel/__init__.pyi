# What type checkers read of the package, which imports its names late.
from stiefel import aio as aio, errors as errors, manifold as manifold, results as results
from stiefel._public import *
from stiefel._sweep import ray as ray
from stiefel._results.error_against_cost import *
from stiefel._results.estimate import *
from stiefel._results.geodesics import *
from stiefel._results.reduced import *
from stiefel._results.server_catalogue import *
from stiefel._results.state_properties import *
from stiefel.errors import *
from stiefel.results import *
from stiefel.version import __version__ as __version__
