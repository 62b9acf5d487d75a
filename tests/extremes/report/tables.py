"""Makes the tables of the report. A row of an extreme has a line for each method."""
from __future__ import annotations

from collections import defaultdict

from records import bounded, fraction, method, number

TRUNCATION = {"truncation", "error"}
KEPT = {"drift", "orthogonality"}


def cell(records, named=True):
    """Returns the measure that uses most of its bound, or the outcome if every run stopped."""
    if not records:
        return ""
    if len({r["outcome"] for r in records}) == 1 and records[0]["outcome"] != "REACHED":
        return records[0]["outcome"]
    worst = max(records, key=lambda r: (bounded(r), fraction(r)))
    if worst["bound"] == 0:
        return "yes" if worst["value"] <= 0 else "no"
    text = f"{worst['measure']} {number(worst['value'])}" if named else number(worst["value"])
    if bounded(worst):
        text += f" {'≤' if worst['value'] <= worst['bound'] else '>'} {number(worst['bound'])}"
    else:
        text += ", no bound"
    if any(r["outcome"] != "REACHED" for r in records):
        text += ", some " + ", ".join(sorted({r["outcome"] for r in records} - {"REACHED"}))
    return text


def truncation(records):
    """Returns the truncation at the lowest and at the highest order."""
    by_order = {}
    for r in records:
        by_order[r["order"]] = max(by_order.get(r["order"], 0), r["value"])
    if len(by_order) < 2:
        return "".join(number(value) for value in by_order.values())
    low, high = min(by_order), max(by_order)
    return f"{number(by_order[low])} (order {low}) … {number(by_order[high])} (order {high})"


def because(records):
    """Returns the reason of the bound of which most is used."""
    reasons = [r for r in records if bounded(r)]
    return max(reasons, key=fraction)["why"].split(";")[0].replace("|", "\\|") if reasons else ""


def seconds(records):
    return f"{sum({(r['system'], r['order'], r['arithmetic']): r['seconds'] for r in records}.values()):.2g}"


def by_arithmetic(records):
    return ([r for r in records if r["arithmetic"] != "plain"], [r for r in records if r["arithmetic"] == "plain"])


def grouped(records):
    groups = defaultdict(list)
    for record in records:
        groups[record["row"], method(record)].append(record)
    return groups.items()


def errors(records):
    """Returns the table of an extreme with columns for rounding, truncation and kept invariants."""
    lines = ["| row | method | rounding, compensated | rounding, plain | truncation | kept, compensated | kept, plain | "
             "bound | s |", "| --- " * 9 + "|"]
    for (row, name), of_it in grouped(records):
        shown = [r for r in of_it if r["measure"] in TRUNCATION]
        kept = [r for r in of_it if r["measure"] in KEPT]
        rounding = [r for r in of_it if r not in shown and r not in kept]
        cells = [cell(part, named=False) for part in by_arithmetic(rounding)]
        cells.append(truncation(shown))
        cells += [cell(part) for part in by_arithmetic(kept)]
        lines.append(f"| {row} | {name} | {' | '.join(cells)} | {because(rounding + kept)} | {seconds(of_it)} |")
    return lines


def measures(records):
    """Returns the table of an extreme that measures neither rounding nor truncation."""
    lines = ["| row | method | compensated | plain | bound | s |", "| --- " * 6 + "|"]
    for (row, name), of_it in grouped(records):
        cells = [cell(part) for part in by_arithmetic(of_it)]
        lines.append(f"| {row} | {name} | {' | '.join(cells)} | {because(of_it)} | {seconds(of_it)} |")
    return lines


def service(records):
    lines = ["| row | measure | value | bound | because | outcome | s |", "| --- " * 7 + "|"]
    for r in records:
        bound = number(r["bound"]) if bounded(r) else ""
        lines.append(f"| {r['row']} | {r['measure']} | {number(r['value'])} | {bound} | {r['why'] or ''} | "
                     f"{r['outcome']} | {r['seconds']:.2g} |")
    return lines


def table(extreme, records):
    if extreme == "service":
        return service(records)
    rounding = [r for r in records if r["measure"] == "rounding"]
    if not rounding:
        return measures(records)
    rows = {r["row"] for r in rounding}
    others = [r for r in records if r["row"] not in rows]
    lines = errors([r for r in records if r["row"] in rows])
    return lines + ([""] + measures(others) if others else [])
