"""
Plots of a run
==============

`plot` draws the attitude, the angular velocity, and the drift beside the estimated error of a run; `polhode` its momentum in body
axes on the momentum sphere. The run is a cubesat of six units that tumbles about its middle axis, in steps of the splitting method.
"""
import matplotlib.pyplot as plt
import numpy as np
import stiefel

box = stiefel.solids.box(10, (0.1, 0.226, 0.366)) + stiefel.solids.box(0.6, (0.002, 0.6, 0.3), at=(0.05, 0.2, 0))
scene = stiefel.body_scene(inertia_tensor=box, angular_velocity=np.radians([1, 12, 1]), step=0.1, method={"name": "splitting"})
run = stiefel.simulate(scene, time=180.0, every=1)
run.plot()
run.polhode()
assert "mode" in run.motion.kind and abs(run["angular_velocity"]).max() > 0.2
plt.show()
