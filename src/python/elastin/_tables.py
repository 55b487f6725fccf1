"""Tables of results, as text and for notebooks."""

from html import escape

from ._elastin import measures, percent, readable, readable_seconds

UNITS = {name: unit for name, unit, _ in measures()}


def error_text(result, name):
    """Relative; of a ratio the difference."""
    if name not in result.errors:
        return ""
    return percent(result.errors[name]) if UNITS[name] else f"{result.errors[name]:+.4f}"


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


def notes_of(result):
    trouble = [] if result.outcome == "converged" else [result.outcome.replace("_", " ") + ": " + result.cause]
    return "; ".join(trouble + [warning.split(";")[0].split("(")[0].strip() for warning in result.warnings])


def of_results(results, swept=None):
    """A row a result. `swept`: keys and the values that the rows have under them, in place of the strategies."""
    main = list(dict.fromkeys(name for result in results for name in result.main if name in result.measures))
    with_error = [name for name in main if UNITS[name] and any(name in result.errors for result in results)]
    head = list(swept) if swept else ["strategy"]
    for name in main:
        head += [name, "error"] if name in with_error else [name]
    rows = []
    for number, result in enumerate(results):
        row = [str(values[number]) for values in swept.values()] if swept else [result.strategy]
        for name in main:
            row.append(readable(name, result.get(name)) if name in result.measures else "")
            if name in with_error:
                row.append(error_text(result, name))
        ran = result.outcome != "unsuited"
        seconds = result.build_seconds + result.solve_seconds
        rows.append(row + [readable_seconds(seconds) if ran else "", notes_of(result)])
    scenes = ", ".join(dict.fromkeys(result.scene for result in results))
    return Table(head + ["seconds", ""], rows, scenes)


def of_result(result):
    """Every measure of one result."""
    rows = [[name, readable(name, value), error_text(result, name)] for name, value in result.measures.items()]
    title = f"{result.scene}, {result.strategy}: {result.outcome}" + (f": {result.cause}" if result.cause else "")
    return Table(["measure", "value", "error"], rows, title)
