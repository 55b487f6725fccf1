"""Tables of results, as text and for notebooks."""

from html import escape

from ._elastin import percent, readable, readable_seconds


def value_text(result, name):
    return readable(name, result.measures[name], result.units[name])


def error_text(result, name):
    """Relative; of a ratio the difference."""
    if name not in result.errors:
        return ""
    return percent(result.errors[name]) if result.units.get(name) else f"{result.errors[name]:+.4f}"


class Table:
    """Rows of words; the first column is a name, the last one notes, the others are numbers."""

    def __init__(self, head, rows, title=""):
        self.head, self.rows, self.title = head, rows, title

    def text(self):
        widths = [max(map(len, column)) for column in zip(self.head, *self.rows)]
        last = len(self.head) - 1
        lines = [self.title] if self.title else []
        for row in [self.head, *self.rows]:
            words = [word.ljust(width) if column in (0, last) else word.rjust(width)
                     for column, (word, width) in enumerate(zip(row, widths))]
            lines.append("  ".join(words).rstrip())
        return "\n".join(lines)

    def html(self):
        def cells(tag, row):
            return "".join(f"<{tag}>{escape(word)}</{tag}>" for word in row)

        caption = f"<caption>{escape(self.title)}</caption>" if self.title else ""
        rows = "".join(f"<tr>{cells('td', row)}</tr>" for row in self.rows)
        return f"<table>{caption}<thead><tr>{cells('th', self.head)}</tr></thead><tbody>{rows}</tbody></table>"


def with_picture(table, picture):
    """HTML of a table with a picture next to it."""
    return (f'<div style="display:flex;gap:1.5em;align-items:flex-start;flex-wrap:wrap">{table.html()}'
            f"<div>{picture}</div></div>")


def of_body(body):
    rows = [["molecules", str(len(body))], ["connections", str(body.proper_connections)]]
    rows += [[name.replace("_", " "), str(len(cells))] for name, cells in body.cells.items()]
    size = body.positions.max(axis=0) - body.positions.min(axis=0)
    rows += [["size", " × ".join(f"{1e3 * side:.4g}" for side in size) + " mm"],
             ["mass", f"{1e3 * body.masses.sum():.4g} g"]]
    return Table(["body", ""], rows)


def of_laboratory(laboratory):
    from . import _pictures
    rows = [["strategy", laboratory.strategy], ["compares", ", ".join(laboratory.strategies)]]
    rows += [["warning", warning] for warning in laboratory.warnings]
    rows += of_body(laboratory.body).rows
    return with_picture(Table(["scene", laboratory.title], rows), _pictures.of_body(laboratory.body))


def of_verdicts(cases):
    rows = []
    for case in cases:
        worst = max(case["expectations"], key=lambda one: abs(one["difference"]) if one["judged"] else -1, default=None)
        detail = case["cause"]
        if worst and worst["measure"] and not detail:
            detail = f"{worst['measure']} {percent(worst['difference'])}"
        rows.append([f"{case['scene']}, {case['strategy']}", case["verdict"], readable_seconds(case["seconds"]), detail])
    passed = sum(case["verdict"] == "passed" for case in cases)
    return Table(["case", "verdict", "seconds", ""], rows, f"{passed} of {len(cases)} passed")


def notes_of(result):
    trouble = [] if result.outcome == "converged" else [result.outcome.replace("_", " ") + ": " + result.cause]
    return "; ".join(trouble + [warning.split(";")[0].split("(")[0].strip() for warning in result.warnings])


def of_results(results, swept=None):
    """A row a result. `swept`: keys and the values that the rows have under them, in place of the strategies."""
    main = list(dict.fromkeys(name for result in results for name in result.main if name in result.measures))
    with_error = [name for name in main if any(name in result.errors and result.units.get(name) for result in results)]
    head = list(swept) if swept else ["strategy"]
    for name in main:
        head += [name, "error"] if name in with_error else [name]
    rows = []
    for number, result in enumerate(results):
        row = [str(values[number]) for values in swept.values()] if swept else [result.strategy]
        for name in main:
            row.append(value_text(result, name) if name in result.measures else "")
            if name in with_error:
                row.append(error_text(result, name))
        ran = result.outcome != "unsuited"
        seconds = result.build_seconds + result.solve_seconds
        rows.append(row + [readable_seconds(seconds) if ran else "", notes_of(result)])
    scenes = ", ".join(dict.fromkeys(result.scene for result in results))
    return Table(head + ["seconds", ""], rows, scenes)


def of_result(result):
    """Every measure of one result."""
    rows = [[name, value_text(result, name), error_text(result, name)] for name in result.measures]
    title = f"{result.scene}, {result.strategy}: {result.outcome}" + (f": {result.cause}" if result.cause else "")
    return Table(["measure", "value", "error"], rows, title)
