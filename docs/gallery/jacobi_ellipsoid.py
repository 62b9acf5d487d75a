"""
Jacobi's geodesics on an ellipsoid
==================================

C. G. J. Jacobi (1839) solved the geodesics on x²/a + y²/b + z²/c = 1 in the coordinates u < v of a point, the roots of
x²/(a − w) + y²/(b − w) + z²/(c − w) = 1 other than 0: ∫ (u / ((u − a)(b − u)(c − u)(ρ − u)))^½ du and
∫ (v / ((v − a)(v − b)(c − v)(v − ρ)))^½ dv along the path stay equal ([ST] section 2.3). The geodesic turns back at the two
curves u = ρ, which Joachimsthal's integral predicts, and by Chasles' theorem its tangents touch the quadric w = ρ.
"""
import matplotlib.pyplot as plt
import numpy as np
import stiefel

a, b, c = squares = np.array([1.0, 4.0, 9.0])
q = np.array([0.1, 0.2, 1.0]) / np.sqrt(1.05)
tangent = np.array([0.9, 0.45, 0.0]) - (np.array([0.9, 0.45, 0.0]) @ q) * q
scene: stiefel.Scene = {"system": "ellipsoid", "inertia": squares, "step": 0.01,
                        "initial": {"q": [q], "qdot": [tangent / np.sqrt(tangent**2 @ squares)]}}
run = stiefel.simulate(scene, time=100.0, every=1, fields=["q", "qdot"])
x, velocity = run["q"] * np.sqrt(squares), run["qdot"] * np.sqrt(squares)
rho = (run["q"][0] ** 2 @ (1 / squares)) * (run["qdot"][0] ** 2).sum() * squares.prod()  # of Joachimsthal's integral
total, product = squares.sum() - (x**2).sum(axis=1), squares.prod() * (x**2 / squares**2).sum(axis=1)  # u + v, u v
v = total / 2 + np.sqrt(total**2 / 4 - product)
u = product / v
weights = 1 / (squares - rho)
touching = (x * velocity @ weights) ** 2 - (x**2 @ weights - 1) * (velocity**2 @ weights)
assert abs(touching).max() < 1e-7 and abs(u.max() - rho) < 1e-6

# In angles from u = a and v = b, which run on and on, the integrands are smooth: w = low + (high - low) sin^2(angle).
phi = np.unwrap(np.arctan2(np.sqrt(np.clip(u - a, 0, None)) * np.sign(x[:, 0]),
                           np.sqrt(np.clip(rho - u, 0, None)) * np.sign(x[:, 0] * np.gradient(u))))
chi = np.unwrap(np.arctan2(np.sqrt(np.clip(v - b, 0, None)) * np.sign(x[:, 1]), np.sqrt(np.clip(c - v, 0, None)) * np.sign(x[:, 2])))
integrals = []
for angle, low, high, one, two in ((phi, a, rho, b, c), (chi, b, c, a, rho)):
    fine = np.linspace(0, abs(angle - angle[0]).max(), 200_001) * np.sign(angle[-1] - angle[0]) + angle[0]
    w = low + (high - low) * np.sin(fine) ** 2
    rates = 2 * np.sqrt(w / ((w - one) * (w - two)))
    sums = np.concatenate([[0], np.cumsum((rates[1:] + rates[:-1]) / 2 * abs(np.diff(fine)))])
    integrals.append(np.interp(abs(angle - angle[0]), abs(fine - fine[0]), sums))
assert integrals[0][-1] > 40 and abs(integrals[0] - integrals[1]).max() < 1e-3

figure = plt.figure(figsize=(10, 4.4), constrained_layout=True)
space, along = figure.add_subplot(1, 2, 1, projection="3d"), figure.add_subplot(1, 2, 2)
space.plot(*x.T, color="tab:blue", linewidth=0.5)
other = np.linspace(b, c, 200)  # the points with u = rho
squared = [(one * (one - rho) * (one - other)) / np.prod(one - squares[squares != one]) for one in squares]
for sign in np.ndindex(2, 2, 2):
    space.plot(*[(1 - 2 * s) * np.sqrt(np.clip(one, 0, None)) for s, one in zip(sign, squared)], color="tab:red", linewidth=2)
space.set_box_aspect(np.sqrt(squares), zoom=1.25)
space.set_axis_off()
space.view_init(15, 30)
space.set_title(f"the geodesic touches the two curves u = {rho:.4f}")
for values, dashes, name in zip(integrals, ("-", "--"), "uv"):
    along.plot(run.time, values, dashes, label=f"integral in {name}")
along.set(xlabel="length of the path", title="Jacobi's integrals along it")
along.legend()
plt.show()
