"""`stiefel describe` and `--help`."""


def test_describe_lists_what_the_json_lists(stiefel):
    table, description = stiefel("describe"), stiefel("describe", "--json").json
    assert table.status == 0
    assert description["limits"]["max_dimension"] == 512
    assert f"\nnumerics id: {description['numerics_id']}\nbuild: {description['build']}\n" in table.out
    assert description["durable"] is False and "\nsessions: in memory, lost when the server ends\n" in table.out
    for system in description["systems"]:
        assert f"\n{system['name']}" in table.out
        for item in system["fields"] + system["invariants"] + system.get("forms", []):
            assert f" {item['name']} " in table.out
        recommended = [line for line in table.out.split(f"\n{system['name']}")[1].split("\n\n")[0].splitlines()
                       if line.startswith("  recommended")]
        assert len(recommended) == len(system.get("recommended", [])) and bool(recommended) != system["discrete"]
        for line, item in zip(recommended, system.get("recommended", [])):
            assert item["method"]["name"] in line and (item["where"] or "(every scene)") in line
    for method in description["methods"]:
        assert f"\n  {method['name']} " in table.out


def test_help_is_status_0_and_tells_the_statuses(stiefel):
    result = stiefel("--help")
    assert result.status == 0
    assert "Exit status: 0 reached, 2 bad input, 3 numerical stop" in result.out
    for command in ("describe", "run", "diagnose", "convert", "tradeoff", "connect"):
        assert stiefel(command, "--help").status == 0
