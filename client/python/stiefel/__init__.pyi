# What type checkers read of the package, which imports its names late.
from stiefel import aio as aio, errors as errors, manifold as manifold, results as results
from stiefel._public import *
from stiefel._sweep import ray as ray
from stiefel.version import __version__ as __version__
