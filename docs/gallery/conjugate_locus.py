"""
Where geodesics stop being the shortest
=======================================

Geodesics from one point of the ellipsoid with semi-axes 1, 1.2 and 1.6, drawn up to their first conjugate points. These form
the conjugate locus opposite to the point, a curve with four cusps (Jacobi's last geometric statement).
"""
import matplotlib.pyplot as plt
import numpy as np
import stiefel

semi_axes = np.array([1.0, 1.2, 1.6])
q = np.array([0.6, 0.64, 0.48])
basis = np.linalg.svd(q[None])[2][1:]
figure = plt.figure(figsize=(9, 5), constrained_layout=True)
whole, near = figure.add_subplot(1, 2, 1, projection="3d"), figure.add_subplot(1, 2, 2, projection="3d")
ends = []
with stiefel.Server.start() as server, stiefel.Client(server.address) as client:
    for k, angle in enumerate(np.linspace(0, 2 * np.pi, 120, endpoint=False)):
        v = np.array([np.cos(angle), np.sin(angle)]) @ basis
        time = client.conjugate_points(semi_axes**2, q[None], v[None], time=9)[0].time
        scene: stiefel.Scene = {"system": "ellipsoid", "inertia": semi_axes**2, "step": time / 60,
                                "initial": {"q": q[None], "qdot": v[None]}}
        way = stiefel.simulate(scene, to=60, every=1, fields=["q"])["q"] * semi_axes
        ends.append(way[-1])
        if k % 6 == 0:
            whole.plot(*way.T, linewidth=0.6, color="tab:blue")
        near.plot(*way[-10:].T, linewidth=0.5, color="tab:blue")
locus = np.array(ends + ends[:1])
assert np.allclose(np.sum((locus / semi_axes)**2, axis=1), 1, atol=1e-12)
along = np.diff(locus, axis=0)  # which turns back at a cusp
assert (np.sum(along * np.roll(along, 1, axis=0), axis=1) < 0).sum() == 4
for axes in (whole, near):
    axes.plot(*locus.T, color="tab:red", linewidth=1.5)
    axes.set_axis_off()
    axes.view_init(*np.degrees([-np.arcsin(q[2]), np.arctan2(q[1], q[0]) + np.pi]))
whole.plot(*(q * semi_axes)[:, None], "ko", markersize=3)
whole.set_box_aspect(semi_axes, zoom=1.5)
centre, width = (locus.min(axis=0) + locus.max(axis=0)) / 2, np.ptp(locus, axis=0).max()
near.set(xlim=centre[0] + width * np.array([-0.6, 0.6]), ylim=centre[1] + width * np.array([-0.6, 0.6]),
         zlim=centre[2] + width * np.array([-0.6, 0.6]))
near.set_box_aspect((1, 1, 1), zoom=1.5)
whole.set_title("geodesics up to their first conjugate point")
near.set_title("the conjugate locus has four cusps")
plt.show()
