"""`stiefel convert`."""
import numpy as np


def test_convert_prints_a_scene_that_runs(stiefel, write, scene, tmp_path):
    scene = write(scene)
    done = stiefel("convert", scene, "--to", "symmetric_rigid_body")
    assert done.status == 0 and done.json["scene"]["system"] == "symmetric_rigid_body"
    assert 0 < done.json["margins"]["S_M"] < 2
    alone = stiefel("convert", scene, "--to", "symmetric_rigid_body", "--output", "symmetric.json")
    assert alone.json == {"margins": done.json["margins"]}
    one, other = (stiefel("run", path, "--to", 10, "--every", 10, "--fields", "M").json["samples"][-1]["fields"]["M"]
                  for path in (scene, tmp_path / "symmetric.json"))
    np.testing.assert_allclose(other, one, atol=1e-12)


def test_blocks_are_printed_in_the_order_of_their_names(stiefel, write, scene):
    for target in ["rigid_body", "symmetric_rigid_body", "mclachlan_scovel", "stiefel"]:
        for _ in range(3):
            blocks = list(stiefel("convert", write(scene), "--to", target).json["scene"]["initial"])
            assert blocks == sorted(blocks)


def test_convert_to_velocity(stiefel, write, scene):
    blocks = stiefel("convert", write(scene), "--to", "velocity").json["blocks"]
    assert sorted(blocks) == ["Q", "Qdot"] and np.shape(blocks["Qdot"]) == (3, 3)


def test_convert_outside_a_domain(stiefel, write, scene):
    done = stiefel("convert", write(scene), "--to", "symmetric_rigid_body", "--epsilon", 1)
    assert done.status == 2 and "S_M" in done.err and "the bound 2" in done.err
    assert "--epsilon: outside the domain" in done.err
    fast = write({**scene, "step": 1e3}, "fast.json")
    done = stiefel("convert", fast, "--to", "moser_veselov_pair")
    assert done.status == 2 and "fast.json: step: outside the domain" in done.err


def test_a_useless_number_is_refused(stiefel, write, scene):
    for option in ("--epsilon", "--parameter"):
        done = stiefel("convert", write(scene), "--to", "right_rigid_body", option, 0.5)
        assert done.status == 2 and f"{option}: 0.5: must be absent in a conversion to right_rigid_body" in done.err
