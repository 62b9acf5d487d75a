"""Quaternions beside their definition: Hamilton's products i j = k, and q x q^-1."""
import numpy as np
import pytest

from stiefel import _rotations

RNG = np.random.default_rng(7)
Q = RNG.standard_normal((50, 4))
Q /= np.linalg.norm(Q, axis=1, keepdims=True)
X = RNG.standard_normal((50, 3))


def of_hamilton(p, q):
    """The product by the 2 x 2 matrices of i, j, k."""
    i, j = np.array([[1j, 0], [0, -1j]]), np.array([[0, 1], [-1, 0]], complex)
    units = np.array([np.eye(2), i, j, i @ j])
    matrix = np.einsum("ka,aij->kij", p, units) @ np.einsum("ka,aij->kij", q, units)
    return np.einsum("kij,aji->ka", matrix, units.conj().transpose(0, 2, 1)).real / 2


def test_products_and_rotated_vectors():
    np.testing.assert_allclose(_rotations.product(Q, Q[::-1]), of_hamilton(Q, Q[::-1]), rtol=0, atol=1e-15)
    pure = np.concatenate([np.zeros((50, 1)), X], axis=1)
    turned = of_hamilton(of_hamilton(Q, pure), _rotations.inverse(Q))
    np.testing.assert_allclose(_rotations.rotated(Q, X), turned[:, 1:], rtol=0, atol=1e-14)
    np.testing.assert_allclose(np.einsum("kij,kj->ki", _rotations.to_matrices(Q), X), turned[:, 1:], rtol=0, atol=1e-14)


@pytest.mark.parametrize("angle", [0.0, 1e-9, 1.0, np.pi - 1e-9, np.pi])
def test_matrices_there_and_back(angle):
    for axis in np.concatenate([np.eye(3), -np.eye(3), X[:5] / np.linalg.norm(X[:5], axis=1, keepdims=True)]):
        q = np.array([np.cos(angle / 2), *np.sin(angle / 2) * axis])
        found = _rotations.of_matrices(_rotations.to_matrices(q))
        assert found[0] >= 0 and min(abs(found - q).max(), abs(found + q).max()) < 1e-15
