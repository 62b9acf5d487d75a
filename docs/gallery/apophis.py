"""
The tumbling asteroid (99942) Apophis
=====================================

P. Pravec et al. (2014) found two periods in the light of Apophis, precession P_φ = 27.38 h and rotation P_ψ = 263 h in a short
axis mode, and moments in the ratios I₁/I₃ = 0.61 and I₂/I₃ = 0.965. They fix the motion, from whose attitude both periods are
read. Predicted are the energy over that of a rotation about the short axis with the same momentum, which the paper has as
1.024 ± 0.013, and the period of the long axis, 30.56 h.
"""
import matplotlib.pyplot as plt
import numpy as np
import stiefel

hour, moments = 3600.0, np.array([0.61, 0.965, 1.0])
P_phi, P_psi, w = 27.38 * hour, 263 * hour, 1 / moments

# With g = sin²ψ/I₁ + cos²ψ/I₂ and D = 2E/L²: φ′ = L g and |ψ′| = L ((g − D)(g − 1/I₃))^½, so that P_φ/P_ψ depends on D alone.
# It falls from D = 1/I₃ to 0 at the separatrix D = 1/I₂.
psi = 2 * np.pi * np.arange(4096) / 4096
g, low, high = np.sin(psi) ** 2 * w[0] + np.cos(psi) ** 2 * w[1], w[2], w[1]
for _ in range(60):
    D = (low + high) / 2
    slow = 2 * np.pi / np.sqrt((g - D) * (g - w[2]))  # its mean is the time of a turn of ψ where L = 1
    low, high = (D, high) if 2 * np.pi / (g * slow).mean() > P_phi / P_psi else (low, D)
cosine = np.sqrt((w[1] - D) / (w[1] - w[2]))  # of the nutation θ at ψ = 0
sine = np.sqrt(1 - cosine**2)
omega = slow.mean() / P_psi * np.array([0, sine, cosine]) * w
attitude = [[1, 0, 0], [0, cosine, -sine], [0, sine, cosine]]  # the momentum is along z in space
scene = stiefel.body_scene(moments=moments, attitude=attitude, angular_velocity=omega, step=hour / 4)
run = stiefel.simulate(scene, time=4 * P_psi, every=1, fields=["Q"])
Q = run["Q"]  # Rz(φ) Rx(θ) Rz(ψ)
phi, psi = np.unwrap(np.arctan2(Q[:, 0, 2], -Q[:, 1, 2])), np.unwrap(np.arctan2(Q[:, 2, 0], Q[:, 2, 1]))
seen = [2 * np.pi * run.time[-1] / abs(angle[-1] - angle[0]) / hour for angle in (phi, psi)]
ends = run["Q"][:, :, 0] @ np.array([1, 1j, 0])  # of the long axis, seen from the momentum
long_axis = 2 * np.pi * run.time[-1] / abs(np.ptp(np.unwrap(np.angle(ends)))) / hour
assert np.allclose(seen, [27.38, 263], rtol=1e-6) and abs(D * moments[2] - 1.024) < 0.013 and abs(long_axis - 30.56) < 0.03

figure, (path, turning) = plt.subplots(1, 2, figsize=(10, 4.2), constrained_layout=True, width_ratios=[1, 1.4])
for axis, dashes, hours in ((2, "-", 263), (0, ":", 20)):
    x, y, _ = Q[run.time <= hours * hour, :, axis].T
    path.plot(x, y, dashes, label=f"{'short' if axis else 'long'} axis, {hours} h", linewidth=1.2)
path.add_patch(plt.Circle((0, 0), 1, fill=False, color="0.8"))
path.set(aspect="equal", title="seen from the momentum", xticks=[], yticks=[], xlim=(-1.05, 1.05), ylim=(-1.05, 1.35))
path.legend(loc="upper left", fontsize=8, ncol=2, frameon=False)
turning.plot(run.time / hour, phi / (2 * np.pi), "-", label=f"φ: a turn in {seen[0]:.2f} h")
turning.plot(run.time / hour, psi / (2 * np.pi), "--", label=f"ψ: a turn in {seen[1]:.1f} h, backwards")
turning.plot(run.time / hour, np.degrees(np.arccos(Q[:, 2, 2])) / 10, ":", label="θ, in tens of degrees")
turning.set(xlabel="hours", title="turns")
turning.legend()
plt.show()
