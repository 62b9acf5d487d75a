"""The generated messages and enums of all files of `stiefel.v1`."""
from stiefel.v1.catalogue_pb2 import *  # noqa: F401,F403
from stiefel.v1.conjugate_pb2 import *  # noqa: F401,F403
from stiefel.v1.connect_pb2 import *  # noqa: F401,F403
from stiefel.v1.conversion_pb2 import *  # noqa: F401,F403
from stiefel.v1.diagnosis_pb2 import *  # noqa: F401,F403
from stiefel.v1.error_pb2 import *  # noqa: F401,F403
from stiefel.v1.linearization_pb2 import *  # noqa: F401,F403
from stiefel.v1.numbers_pb2 import *  # noqa: F401,F403
from stiefel.v1.outcome_pb2 import *  # noqa: F401,F403
from stiefel.v1.price_pb2 import *  # noqa: F401,F403
from stiefel.v1.run_pb2 import *  # noqa: F401,F403
from stiefel.v1.scene_pb2 import *  # noqa: F401,F403
from stiefel.v1.session_pb2 import *  # noqa: F401,F403
from stiefel.v1.simulation_pb2 import *  # noqa: F401,F403
from stiefel.v1.summary_pb2 import *  # noqa: F401,F403
from stiefel.v1.tensor_pb2 import *  # noqa: F401,F403
from stiefel.v1.tradeoff_pb2 import *  # noqa: F401,F403
