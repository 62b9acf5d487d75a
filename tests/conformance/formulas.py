"""The formulas that Describe prints, as numpy code. test_formulas.py compares their values with what the server
reports.

Every entry belongs to one exact text, so that a changed text has no entry until somebody writes it anew. An entry is a
function of a state `x` (`State` in test_formulas.py): the fields by name, `lam` and `Lam` for the inertia, `h`, `mu`,
`U` of a discrete system, `x.dot(field)` for the time derivative and `x.next` for the state one step later.

Entries of INVARIANTS return the values by their indices: {(): energy}, {(1, 2): m_12, ...}. Entries of the other tables
return pairs (left side, right side), which must be equal.
"""
import numpy as np


def comm(A, B):
    return A @ B - B @ A


def J_inverse(lam, X):
    """Returns X_ij / (lambda_i + lambda_j)."""
    return X / (lam[:, None] + lam)


def lyapunov(K, E):
    """Returns the X with K X + X K = E."""
    one = np.eye(len(K))
    return np.linalg.solve(np.kron(K, one) + np.kron(one, K.T), E.ravel()).reshape(K.shape)


def hat(w):
    x, y, z = w.ravel()
    return np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])


def about(axis, angle):
    """Returns the rotation about a coordinate axis."""
    c, s, (j, k) = np.cos(angle), np.sin(angle), ((axis + 1) % 3, (axis + 2) % 3)
    R = np.eye(3)
    R[[j, j, k, k], [j, k, j, k]] = c, -s, s, c
    return R


def ZXZ(angles):
    a, b, c = angles.ravel()
    return about(2, a) @ about(0, b) @ about(2, c)


def rotation(q):
    """Returns the Q with Q v = q v q* for Hamilton's quaternion q."""
    w, v = q.ravel()[0], q.ravel()[1:]
    return (w * w - v @ v) * np.eye(3) + 2 * np.outer(v, v) + 2 * w * hat(v)


def traces(pencil, K):
    """Returns {(k, j): coefficient of mu^j in tr A(mu)^k} for k = 1..K, where A(mu) = sum_i pencil[i] mu^i."""
    power, out = [np.eye(len(pencil[0]))], {}
    for k in range(1, K + 1):
        product = [np.zeros_like(pencil[0]) for _ in range(len(power) + len(pencil) - 1)]
        for i, A in enumerate(pencil):
            for j, B in enumerate(power):
                product[i + j] = product[i + j] + A @ B
        power = product
        out.update({(k, j): np.trace(A) for j, A in enumerate(power)})
    return out


def elements(A):
    return {(i, j): A[i, j] for i in range(A.shape[0]) for j in range(A.shape[1])}


def U_of_momentum(x):
    """Returns a skew U with Q^T Q U Lambda + Lambda U Q^T Q = M. It is unique up to a V with Q V = 0."""
    N, pi = len(x.lam), x.Q.T @ x.Q
    skew = []
    for i in range(N):
        for j in range(i):
            E = np.zeros((N, N))
            E[i, j], E[j, i] = 1, -1
            skew.append(E)
    columns = np.stack([(pi @ E @ x.Lam + x.Lam @ E @ pi).ravel() for E in skew], 1)
    c = np.linalg.lstsq(columns, x.M.ravel(), rcond=1e-12)[0]
    return sum(ck * E for ck, E in zip(c, skew))


def momentum_of_U(x):
    U = U_of_momentum(x)
    pi = x.Q.T @ x.Q
    return [(x.M, pi @ U @ x.Lam + x.Lam @ U @ pi), (x.Qdot, x.Q @ U)]


def stiefel_A(x, U):
    return comm(x.Q.T @ x.Q, U @ x.Lam @ U)


def double_bracket_generators(x):
    X, Y = x.P @ x.Q.conj().T - x.Q @ x.P.conj().T, x.P.conj().T @ x.Q - x.Q.conj().T @ x.P
    return J_inverse(x.lam_u, X), J_inverse(x.lam_v, Y)


def double_bracket_hamiltonian(x):
    U, V = double_bracket_generators(x)
    inner = lambda A, B: np.trace(A.conj().T @ B).real / 2
    J = lambda lam, A: lam[:, None] * A + A * lam
    return {(): inner(U, J(x.lam_u, U)) / 4 + inner(V, J(x.lam_v, V)) / 4}


def body_energy(x):
    Omega = J_inverse(x.lam, x.M)
    return {(): np.trace(x.Lam @ Omega.T @ Omega) / 2}


def casimirs(x):
    w = np.linalg.eigvalsh(1j * x.M)[::-1][:len(x.lam) // 2]
    return {(k,): wk for k, wk in enumerate(w)}


def discrete_hamiltonian(x):
    eigenvalues = np.linalg.eigvals(x.h * x.M / 2)
    return {(): np.exp(np.arcsinh(eigenvalues)).sum().real - np.trace(x.Lam @ x.U)}


def ellipsoid_lax(x):
    q, lam = x.q.ravel(), x.lam
    p = x.p.ravel() if hasattr(x, "p") else lam * x.Qdot.ravel()
    D = (p / lam @ q)**2 - (p / lam @ p) * (q / lam @ q)
    pencil = [np.outer(q, q) * D / (q / lam @ q), np.outer(q, p) - np.outer(p, q), x.Lam]  # of mu M(mu)
    return {(k, j - k): value for (k, j), value in traces(pencil, len(lam)).items()}


def discrete_lax(x):
    M = x.Q_prev.T @ x.Q @ x.Lam - x.Lam @ x.Q.T @ x.Q_prev
    return traces([x.Lam @ x.Lam, M, -x.Q_prev.T @ x.Q_prev], len(x.lam))


INVARIANTS = {
    "1/2 tr(Lambda Omega^T Omega)": body_energy,
    "Q M Q^T": lambda x: elements(x.Q @ x.M @ x.Q.T),
    "Q^T M Q": lambda x: elements(x.Q.T @ x.M @ x.Q),
    "w_0 >= w_1 >= ... >= 0 of the eigenvalues +-i w_k of M": casimirs,
    "coefficients of mu^j in tr((M + mu Lambda^2)^k), k = 2..N":
        lambda x: traces([x.M, x.Lam @ x.Lam], len(x.lam)),
    "P Q^T": lambda x: elements(x.P @ x.Q.T),
    "P Q^-1": lambda x: elements(x.P @ np.linalg.inv(x.Q)),
    "tr exp(asinh(h M / 2)) - tr(Lambda U), U Lambda - Lambda U^T = h M": discrete_hamiltonian,
    "1/2 tr(S Lambda^-1 S^T), S = Q' Lambda": lambda x: {(): np.sum((x.Qdot * x.lam)**2 / x.lam) / 2},
    "S Q^T - Q S^T, n x n": lambda x: elements((x.Qdot * x.lam) @ x.Q.T - x.Q @ (x.Qdot * x.lam).T),
    "P Q^T = (k + m) / 2, k = P Q^T + Q P^T, m = P Q^T - Q P^T": lambda x: elements(x.P @ x.Q.T),
    "Q Lambda Q_prev^T - Q_prev Lambda Q^T, n x n":
        lambda x: elements(x.Q @ x.Lam @ x.Q_prev.T - x.Q_prev @ x.Lam @ x.Q.T),
    "coefficients of mu^j in tr L(mu)^k, L(mu) = Lambda^2 + mu (Q_prev^T Q Lambda - Lambda Q^T Q_prev)"
    " - mu^2 Q_prev^T Q_prev": discrete_lax,
    "1/2 q'^T Lambda q'": lambda x: {(): np.sum(x.lam * x.Qdot**2) / 2},
    "(q^T Lambda^-1 q) (q'^T q')": lambda x: {(): np.sum(x.q**2 / x.lam) * np.sum(x.Qdot**2)},
    "coefficients of mu^j in tr M(mu)^k, M(mu) = q p^T - p q^T + mu Lambda + q q^T D / (mu q^T Lambda^-1 q), "
    "D = (p^T Lambda^-1 q)^2 - (p^T Lambda^-1 p) (q^T Lambda^-1 q), p = Lambda q' if not given": ellipsoid_lax,
    "1/4 <U, J_U U> + 1/4 <V, J_V V>, <A, B> = 1/2 tr(A^+ B), J_U U = Lambda_U U + U Lambda_U, "
    "J_V V = Lambda_V V + V Lambda_V": double_bracket_hamiltonian,
    "[c, k]: the k-th singular value of Q, P, Q + P and Q + i P for c = 0 to 3": lambda x: {
        (c, k): s for c, A in enumerate([x.Q, x.P, x.Q + x.P, x.Q + 1j * x.P])
        for k, s in enumerate(np.linalg.svd(A, compute_uv=False))},
}

# DiagnoseResponse.orthogonality is the largest element of these matrices.
ORTHOGONALITY = {
    "Q Q^T = I": lambda x: x.Q @ x.Q.T - np.eye(len(x.Q)),
    "q^T q = 1": lambda x: x.q @ x.q.T - 1,
}


def orthonormal(Q):
    return [(Q @ Q.T, np.eye(len(Q)))]


def skew(A):
    return [(A, -A.T)]


def invertible(A):
    return [(np.linalg.inv(A) @ A, np.eye(len(A)))]


def in_GL_momentum(x, h):
    G = np.linalg.inv(x.Q) @ x.P
    return [(x.M, (G - np.linalg.inv(G)) / x.epsilon - x.mu * x.Lam @ x.Lam / h)] + skew(x.M)


def left_costate(x):
    return [(x.Q.T @ x.P - x.P.T @ x.Q, x.epsilon * x.M)]


def right_costate(x):
    return [(x.P @ x.Q.T - x.Q @ x.P.T, x.epsilon * x.M)]


def Omega_of_M(x):
    return [(x.Omega, J_inverse(x.lam, x.M))]


# Blocks and fields. `A` is the block or field that the text describes.
FIELDS = {
    "frame, orthogonal, body to space; absent in a momentum-only scene": lambda x, A: orthonormal(A),
    "frame, orthogonal": lambda x, A: orthonormal(A),
    "frame, orthonormal rows": lambda x, A: orthonormal(A),
    "frame one step before": lambda x, A: orthonormal(A) + [(x.next.Q_prev, x.Q)],
    "frame one step before, orthonormal rows": lambda x, A: orthonormal(A) + [(x.next.Q_prev, x.Q)],
    "invertible": lambda x, A: invertible(A),
    "body momentum, skew": lambda x, A: skew(A),
    "momentum, skew": lambda x, A: skew(A),
    "momentum, skew: may be given instead of the block before it": lambda x, A: skew(A),
    "body angular velocity: Omega_ij = M_ij / (lambda_i + lambda_j) in principal axes": lambda x, A: Omega_of_M(x),
    "body angular velocity: Omega_ij = M_ij / (lambda_i + lambda_j)": lambda x, A: Omega_of_M(x),
    "angular velocity: Omega_ij = M_ij / (lambda_i + lambda_j)": lambda x, A: Omega_of_M(x),
    "J^-1(M): Omega_ij = M_ij / (lambda_i + lambda_j)": lambda x, A: Omega_of_M(x),
    "N = 3, det Q = 1: w, x, y, z, body to space; sign continuous":
        lambda x, A: [(x.Q, rotation(A)), (A @ x.next.quaternion.T > 0.9, True)],
    "N = 3: the vector of Omega": lambda x, A: [(x.Omega, hat(A))],
    "N = 3: the vector of Q Omega Q^T, in space axes": lambda x, A: [(x.Q @ x.Omega @ x.Q.T, hat(A))],
    "N = 3: the vector of Q M Q^T, in space axes": lambda x, A: [(x.Q @ x.M @ x.Q.T, hat(A))],
    "N = 3, det Q = 1: angles in rad in one of SciPy's sequences, euler_angles_ZXZ about axes of the body, euler_angles_zxz "
    "of space; the first and the third jump by 2 pi, and a client unwraps them along a run; within 1e-7 of gimbal lock the "
    "third is 0": lambda x, A: [(x.Q, ZXZ(A))],
    "N = 3, det Q = 1: the time derivatives of these angles; the largest double where infinite, at gimbal lock":
        lambda x, A: [(x.Q @ x.Omega, (ZXZ(x.euler_angles_ZXZ + 3e-6 * A) - ZXZ(x.euler_angles_ZXZ - 3e-6 * A)) / 6e-6)],
    "costate, Q^T P - P^T Q = epsilon M": lambda x, A: left_costate(x),
    "costate, P Q^T - Q P^T = epsilon M": lambda x, A: right_costate(x),
    "M = (Q^T P - P^T Q) / epsilon": lambda x, A: left_costate(x),
    "M = (P Q^T - Q P^T) / epsilon": lambda x, A: right_costate(x),
    "B = Q M, so that Q^T B is skew": lambda x, A: [(A, x.Q @ x.M)] + skew(x.Q.T @ A),
    "body momentum, M = (Lambda U - U^T Lambda) / h, U = Q_prev^T Q":
        lambda x, A: [(A, (x.Lam @ x.Q_prev.T @ x.Q - x.Q.T @ x.Q_prev @ x.Lam) / x.h)],
    "M = (Q^-1 P - P^-1 Q) / epsilon - mu Lambda^2, skew": lambda x, A: in_GL_momentum(x, 1),
    "M = (Q^-1 P - P^-1 Q) / epsilon - mu Lambda^2 / h, skew": lambda x, A: in_GL_momentum(x, x.h),
    "S = Q' Lambda": lambda x, A: [(A, x.dot("Q") * x.lam)],
    "Q', velocity of the frame": lambda x, A: [(A, x.dot("Q"))],
    "M = Q^T S - S^T Q, N <= 4096": lambda x, A: [(A, x.Q.T @ x.S - x.S.T @ x.Q)],
    "M = Q^T P - P^T Q, N <= 4096": lambda x, A: [(A, x.Q.T @ x.P - x.P.T @ x.Q)],
    "costate, any with Q^T P - P^T Q = M = Q^T Q U Lambda + Lambda U Q^T Q, Q' = Q U":
        lambda x, A: [(x.Q.T @ A - A.T @ x.Q, x.M), (x.Qdot, x.dot("Q"))] + momentum_of_U(x),
    "momentum, skew: M = Q^T Q U Lambda + Lambda U Q^T Q, Q' = Q U":
        lambda x, A: skew(A) + [(x.Qdot, x.dot("Q"))] + momentum_of_U(x),
    "unit vector": lambda x, A: [(A @ A.T, 1)],
    "unit vector; x = Lambda^1/2 q has x^T Lambda^-1 x = 1":
        lambda x, A: [(np.sum((np.sqrt(x.lam) * A)**2 / x.lam), 1)],
    "velocity, orthogonal to q; exactly one of qdot and p": lambda x, A: [(A, x.dot("q")), (A @ x.q.T, 0)],
    "q', velocity, if given": lambda x, A: [(A, x.dot("q"))],
    "q', velocity": lambda x, A: [(A, x.dot("q"))],
    "costate": lambda x, A: costate_of_ellipsoid(x),
    "costate, if given": lambda x, A: costate_of_ellipsoid(x),
}


def costate_of_ellipsoid(x):
    """Returns both sides of q' = -U q, U = Lambda^-1 M Lambda^-1 / (q^T Lambda^-1 q), M = q p^T - p q^T; [ST] (9)."""
    q, p, lam = x.q.ravel(), x.p.ravel(), x.lam
    M = np.outer(q, p) - np.outer(p, q)
    return [(x.dot("q").ravel(), -(M / lam[:, None] / lam) @ q / (q / lam @ q))]


def discrete_body(x):
    """Returns both sides of U Lambda - Lambda U^T = h M_k and Q_{k+1} = Q_k U, and whether U is on the branch of the
    identity."""
    near = np.linalg.eigvals(x.U @ x.Lam).real.min() > 0
    return [(x.U @ x.Lam - x.Lam @ x.U.T, x.h * x.M), (x.next.Q, x.Q @ x.U), (near, True)]


def frames_equation(x):
    K, E = (x.Q / x.lam) @ x.Q.T, -2 * x.dot("Q") @ x.dot("Q").T
    return [(x.dot("Q"), x.S / x.lam), (x.dot("S"), lyapunov(K, E) @ x.Q)]


def costate_equation(x):
    U = U_of_momentum(x)
    return [(x.dot("Q"), x.Q @ U), (x.dot("P"), x.P @ U - x.Q @ stiefel_A(x, U))] + momentum_of_U(x)


def momentum_equation(x):
    U = U_of_momentum(x)
    return [(x.dot("Q"), x.Q @ U), (x.dot("M"), comm(x.M, U) - stiefel_A(x, U))] + momentum_of_U(x)


def ellipsoid_equation(x):
    q, v = x.q.ravel(), x.Qdot.ravel()
    return [(x.dot("Qdot").ravel(), -(v @ v) / (q / x.lam @ q) * q / x.lam)]


def double_bracket_equation(x):
    U, V = double_bracket_generators(x)
    return [(x.dot("Q"), U @ x.Q - x.Q @ V), (x.dot("P"), U @ x.P - x.P @ V)]


def reduced_equation(x):
    A = x.P @ x.Q.T
    return [(x.dot("Q"), x.Q @ J_inverse(x.lam, x.Q.T @ (A - A.T) @ x.Q) / x.epsilon),
            (x.next.P @ x.next.Q.T, A), (x.next.P, A @ x.next.Q)]


def in_GL_equation(x):
    rate = J_inverse(x.lam, x.M) + x.mu * x.Lam
    return [(x.dot("Q"), x.Q @ rate), (x.dot("P"), x.P @ rate)]


def in_GL_map(x):
    factor = np.linalg.inv(x.Q) @ x.next.Q
    U = factor - x.mu * x.Lam
    return [(U @ x.Lam - x.Lam @ U.T, x.h * x.M), (U @ U.T, np.eye(len(U))), (x.next.P, x.P @ factor)]


def discrete_frames_map(x):
    B = (x.next.Q @ x.Lam + x.Q_prev @ x.Lam) @ x.Q.T
    return [(x.next.Q @ x.Lam + x.Q_prev @ x.Lam, B @ x.Q), (B, B.T)]


EQUATIONS = {
    "Q' = Q Omega, M' = [M, Omega], M = Lambda Omega + Omega Lambda": lambda x: [
        (x.dot("Q"), x.Q @ x.Omega), (x.dot("M"), comm(x.M, x.Omega)), (x.M, x.Lam @ x.Omega + x.Omega @ x.Lam)],
    "Q' = Omega Q, M' = [Omega, M], M = Lambda Omega + Omega Lambda": lambda x: [
        (x.dot("Q"), x.Omega @ x.Q), (x.dot("M"), comm(x.Omega, x.M)), (x.M, x.Lam @ x.Omega + x.Omega @ x.Lam)],
    "Q' = Q Omega, P' = P Omega, M = (Q^T P - P^T Q) / epsilon": lambda x: [
        (x.dot("Q"), x.Q @ x.Omega), (x.dot("P"), x.P @ x.Omega)] + left_costate(x),
    "Q' = Omega Q, P' = Omega P, M = (P Q^T - Q P^T) / epsilon": lambda x: [
        (x.dot("Q"), x.Omega @ x.Q), (x.dot("P"), x.Omega @ x.P)] + right_costate(x),
    "Q' = Q J^-1(Q^T (A - A^T) Q) / epsilon, A = P Q^T constant, P = A Q": reduced_equation,
    "Q' = Q J^-1(Q^T B), B' = B J^-1(Q^T B), M = Q^T B": lambda x: [
        (x.dot("Q"), x.Q @ J_inverse(x.lam, x.Q.T @ x.B)), (x.dot("B"), x.B @ J_inverse(x.lam, x.Q.T @ x.B)),
        (x.M, x.Q.T @ x.B)],
    "Q' = Q (Omega + mu Lambda), P' = P (Omega + mu Lambda), Omega = J^-1(M)": in_GL_equation,
    "Q' = S Lambda^-1, S' = B Q, K B + B K = -2 Q' Q'^T, K = Q Lambda^-1 Q^T": frames_equation,
    "Q' = Q U, P' = P U - Q A, A = [Q^T Q, U Lambda U], Q^T Q U Lambda + Lambda U Q^T Q = M": costate_equation,
    "Q' = Q U, M' = [M, U] - A, A = [Q^T Q, U Lambda U], Q^T Q U Lambda + Lambda U Q^T Q = M": momentum_equation,
    "q'' = -((q'^T q') / (q^T Lambda^-1 q)) Lambda^-1 q": ellipsoid_equation,
    "Q' = U Q - Q V, P' = U P - P V, U = J_U^-1(P Q^+ - Q P^+), V = J_V^-1(P^+ Q - Q^+ P)": double_bracket_equation,
    "U Lambda - Lambda U^T = h M_k, Q_{k+1} = Q_k U, M_{k+1} = U^T M_k U":
        lambda x: discrete_body(x) + [(x.next.M, x.U.T @ x.M @ x.U)],
    "U Lambda - Lambda U^T = h M_k, Q_{k+1} = Q_k U, P_{k+1} = P_k U":
        lambda x: discrete_body(x) + [(x.next.P, x.P @ x.U)],
    "h M_k = Lambda V - V^T Lambda, V = Q_{k-1}^T Q_k, U Lambda - Lambda U^T = h M_k, Q_{k+1} = Q_k U":
        lambda x: discrete_body(x) + [(x.h * x.M, x.Lam @ x.Q_prev.T @ x.Q - x.Q.T @ x.Q_prev @ x.Lam)],
    "U Lambda - Lambda U^T = h M_k, Q_{k+1} = Q_k (U + mu Lambda), P_{k+1} = P_k (U + mu Lambda)": in_GL_map,
    "Q_{k+1} Lambda + Q_{k-1} Lambda = B_k Q_k, B_k symmetric": discrete_frames_map,
}


def canonical(x, u, v):
    inner = lambda A, B: -np.trace(A @ B) / 2
    xi_1, xi_2 = x.Q.T @ u["Q"], x.Q.T @ v["Q"]
    return inner(v["M"], xi_1) - inner(u["M"], xi_2) + inner(x.M, comm(xi_1, xi_2))


def cotangent(x, u, v):
    R = x.S @ (np.eye(len(x.lam)) - x.Q.T @ x.Q / 2)
    W = x.Q.T @ R - R.T @ x.Q
    inner = lambda A, B: np.trace(A.T @ B)
    return inner(v["QU"] @ W + v["QZ"], u["QU"]) - inner(u["QU"] @ W + u["QZ"], v["QU"])


def pairs_form(first, second):
    return lambda x, u, v: np.trace(u[first].T @ v[second]) - np.trace(u[second].T @ v[first])


# Two-forms by the blocks of their tangent vectors and the printed formula.
FORMS = {
    ("Q, M", "<Z_2, xi_1> - <Z_1, xi_2> + <M, [xi_1, xi_2]> of (Q xi_i, Z_i), <A, B> = -1/2 tr(A B)"): canonical,
    ("Q, P", "1/2 tr(eta_2^T xi_1 - eta_1^T xi_2) of (xi_i, eta_i)"):
        lambda x, u, v: np.trace(v["P"].T @ u["Q"] - u["P"].T @ v["Q"]) / 2,
    ("Q_prev, Q", "1/2 tr(u_1 Lambda v_2^T - v_1 Lambda u_2^T) of u = (u_1, u_2), v = (v_1, v_2)"):
        lambda x, u, v: np.trace(u["Q_prev"] @ x.Lam @ v["Q"].T - v["Q_prev"] @ x.Lam @ u["Q"].T) / 2,
    ("Q, S", "tr(u_1^T v_2) - tr(u_2^T v_1) of u = (u_1, u_2), v = (v_1, v_2)"): pairs_form("Q", "S"),
    ("Q, P", "tr(u_1^T v_2) - tr(u_2^T v_1) of u = (u_1, u_2), v = (v_1, v_2)"): pairs_form("Q", "P"),
    ("QU, QZ", "<Q U_2 W + Q Z_2, Q U_1> - <Q U_1 W + Q Z_1, Q U_2> of (Q U_i, Q Z_i), <A, B> = tr(A^T B), "
     "W = Q^T R - R^T Q, R = S (I - 1/2 Q^T Q)"): cotangent,
}
