"""Every array of an ensemble in every shape: taken as it stands, or refused with its shape."""
import itertools

import numpy as np
import pytest

import stiefel

B = 5  #: members; no other size here is a multiple or a part of it
BODY = {"moments": 3, "angular_velocity": 3, "attitude": 4, "inertia_tensor": 6}
RNG = np.random.default_rng(11)


def body_of(count, **change):
    """A scene of `count` bodies, None for one motion."""
    body = {"moments": [1, 2, 3], "angular_velocity": [0.1, 1, 0.1], **change}
    if "inertia_tensor" in change:
        del body["moments"]
    return {"system": "rigid_body", "step": 0.1, "method": {"name": "rk4"}, "body": body,
            **({} if count is None else {"members": count})}


def values(name, count):
    """One valid list for each of `count` bodies, (count, numbers)."""
    one = {"moments": [2, 3, 4], "angular_velocity": [0.1, 1, 0.1], "attitude": [1, 0, 0, 0], "inertia_tensor": [2, 3, 4, 0, 0, 0]}[name]
    turned = np.tile(one, (count, 1)) + 0.01 * RNG.random((count, len(one)))
    return turned / np.linalg.norm(turned, axis=1, keepdims=True) if name == "attitude" else turned


@pytest.mark.parametrize("name, numbers", BODY.items())
def test_a_list_is_common_or_each_member_s_and_of_no_other_shape(client, name, numbers):
    each = values(name, B)
    for given in (each, each.tolist(), each.ravel().tolist(), each.astype("f8", order="F"), [row for row in each]):
        assert list(getattr(stiefel.to_message(body_of(B, **{name: given})).body, name)) == list(each.ravel())
    for given in (each[0], each[0].tolist(), tuple(each[0])):
        assert list(getattr(stiefel.to_message(body_of(B, **{name: given})).body, name)) == list(each[0])
    matrices = {(3, 3), (B, 3, 3)} if name in ("inertia_tensor", "attitude") else set()
    sizes = (1, 2, 3, 4, 6, B, numbers * B)  # those that occur in a scene
    for shape in (shape for rank in (0, 1, 2, 3) for shape in itertools.product(sizes, repeat=rank)):
        for count, right in ((B, {(numbers,), (B, numbers)} | matrices), (None, {(numbers,)} | matrices - {(B, 3, 3)})):
            if shape not in right:
                with pytest.raises(stiefel.InvalidArgument, match=rf"body\.{name}: "):
                    client.create(body_of(count, **{name: np.ones(shape)}))
    for given in (each.T, values(name, 2 * B), each[np.newaxis], each.T.tolist()):
        with pytest.raises(stiefel.InvalidArgument, match=rf"body\.{name}: the shape .*: must be \({numbers}\).* or \({B}, {numbers}\)"):
            stiefel.to_message(body_of(B, **{name: given}))


def test_an_inertia_tensor_may_be_a_symmetric_matrix():
    roots = RNG.normal(size=(B, 3, 3))
    tensors = roots @ roots.transpose(0, 2, 1) + np.eye(3)
    flat = [[I[0, 0], I[1, 1], I[2, 2], I[0, 1], I[0, 2], I[1, 2]] for I in tensors]
    for given, right in ((tensors, flat), (tensors.tolist(), flat), (tensors[0], flat[0]), (list(tensors), flat)):
        read = stiefel.to_message(body_of(B, inertia_tensor=given)).body.inertia_tensor
        assert list(read) == pytest.approx(list(np.ravel(right)), rel=1e-15)
    assert list(stiefel.to_message(body_of(None, inertia_tensor=tensors[1])).body.inertia_tensor) == pytest.approx(flat[1], rel=1e-15)
    wrong = tensors.copy()
    wrong[3, 0, 1] += 0.25
    with pytest.raises(stiefel.InvalidArgument, match=r"inertia_tensor\[3\]: max \|I - I\^T\| = 0.25: must be a symmetric"):
        stiefel.to_message(body_of(B, inertia_tensor=wrong))
    with pytest.raises(stiefel.InvalidArgument, match=r"inertia_tensor: max \|I - I\^T\| = 0.25: must be a symmetric"):
        stiefel.to_message(body_of(None, inertia_tensor=wrong[3]))
    with pytest.raises(stiefel.InvalidArgument, match=r"the shape \(2, 3, 3\): must be \(6\) or \(3, 3\) or \(5, 6\) or \(5, 3, 3\)"):
        stiefel.to_message(body_of(B, inertia_tensor=tensors[:2]))


N = 4
BLOCKS = {"stiefel": ({"Q": np.eye(2, N), "S": np.array([[0, 2, 2, 0], [-1, 0, 0, 1.0]])}, {"inertia": np.array([1.0, 2, 3, 4])}),
          "rigid_body": ({"Q": np.eye(N), "M": np.diag([1.0, 2, 3], 1) - np.diag([1.0, 2, 3], -1)}, {"inertia": np.array([1.0, 2, 3, 4])}),
          "double_bracket": ({"Q": np.eye(2, 3) + 0j, "P": 1j * np.ones((2, 3))}, {"inertia_u": np.array([1.0, 2]), "inertia_v": np.array([1.0, 2, 4])})}


def scene_of(system, count, **change):
    blocks, lists = BLOCKS[system]
    if count is not None:
        blocks = {name: np.stack([block] * count) for name, block in blocks.items()}
    scene = {"system": system, "step": 0.01, "initial": {**blocks, **{k: v for k, v in change.items() if k in blocks}},
             **lists, **{k: v for k, v in change.items() if k in lists}}
    return scene if count is None else {**scene, "members": count}


@pytest.mark.parametrize("system", BLOCKS)
def test_blocks_and_the_lists_beside_them(client, system):
    blocks, lists = BLOCKS[system]
    for count, lead in ((None, ()), (B, (B,))):
        with client.create(scene_of(system, count)) as session:
            assert {name: session.step(to=1, fields=name)[name].shape for name in blocks} == {
                name: (*lead, *block.shape) for name, block in blocks.items()}
    for name, block in blocks.items():
        rows, cols = block.shape
        for count, shapes, rule in ((B, [(rows, cols, B), (B - 1, rows, cols), (1, B, rows, cols), ()], "must be"),
                                    (None, [(1, rows, cols), (B, rows, cols), (rows, cols, 1)], r"must be \(rows, cols\)")):
            for shape in shapes:
                with pytest.raises(stiefel.InvalidArgument, match=rf"initial\.{name}: the shape .*: .*{rule}"):
                    client.create(scene_of(system, count, **{name: np.ones(shape)}))
    for name, one in lists.items():
        own = np.tile(one, (B, 1)) * (1 + np.arange(B))[:, np.newaxis]
        sent = stiefel.to_message(scene_of(system, B, **{name: own}))
        assert list(getattr(sent, name)) == list(own.ravel())
        client.create(sent).delete()
        for given in (own.T, own[:, :-1], own[:-1], own[np.newaxis], own.ravel(), own[:, :1], np.ones(())):
            with pytest.raises(stiefel.InvalidArgument, match=rf"scene\.{name}: the shape .*: must be \({one.size}\) or \({B}, {one.size}\)"):
                client.create(scene_of(system, B, **{name: given}))
        for given in (one[np.newaxis], one[:, np.newaxis], own):
            with pytest.raises(stiefel.InvalidArgument, match=rf"scene\.{name}: the shape .*: must be \({one.size}\)$"):
                client.create(scene_of(system, None, **{name: given}))


@pytest.mark.parametrize("name", ["epsilon", "parameter", "step", "tolerance", "horizon"])
def test_a_number_that_all_members_share_is_one_number(name):
    for shape in ((1,), (B,), (B, 1)):
        with pytest.raises(stiefel.InvalidArgument, match=rf"scene\.{name}: .*: must be one number"):
            stiefel.to_message({**body_of(B), name: np.ones(shape)})
    assert getattr(stiefel.to_message({**body_of(B), name: np.array(0.5)}), name) == 0.5


def test_frames_and_lists_of_calls(client):
    frame = np.eye(1, 3)
    for given in (frame[np.newaxis], np.ones((2, 1, 3))):
        with pytest.raises(stiefel.InvalidArgument, match=r"^pairs\[0\].Q_0: the shape .*: must be \(rows, cols\)"):
            client.geodesics([(given, frame)], inertia=[1, 2, 3])[0]
    with pytest.raises(stiefel.InvalidArgument, match=r"^inertia: the shape \(3, 3\): must be \(numbers\)"):
        client.geodesics([(frame, frame)], inertia=np.diag([1, 2, 3]))[0]
    with pytest.raises(stiefel.InvalidArgument, match=r"^pairs\[0\].Q_T: the shape \(3, 1\): it looks transposed"):
        client.geodesics([(frame, frame.T)], inertia=[1, 2, 3])[0]
    for pairs in ((frame, frame), [(np.ones(()), frame)], np.stack([frame, frame]), [(frame, frame, frame)], [frame, frame], [3]):
        with pytest.raises(stiefel.InvalidArgument, match=r"^pairs\[0\]: .+: must be two frames \(Q_0, Q_T\)"):
            client.geodesics(pairs, metric="euclidean")
    with pytest.raises(stiefel.InvalidArgument, match="^inertia: is empty: .* or metric be euclidean, canonical or beta"):
        client.geodesics([(frame, frame)])


@pytest.mark.parametrize("mark", ["\ufeff", ""])
def test_a_byte_order_mark_is_no_part_of_a_scene(tmp_path, mark):
    (tmp_path / "scene.json").write_text(mark + '{"step": 0.5}', encoding="utf-8")
    assert stiefel.to_message(tmp_path / "scene.json").step == 0.5
    (tmp_path / "scene.json").write_text('{"step": 0.5}', encoding="utf-16")
    with pytest.raises(stiefel.InvalidArgument, match="scene.json: byte 0: must be UTF-8"):
        stiefel.to_message(tmp_path / "scene.json")
