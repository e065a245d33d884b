"""CSV files in and out."""
import csv


def write(file, rows):
    columns = list(dict.fromkeys(key for row in rows for key in row))
    with open(file, "w", newline="") as out:
        writer = csv.DictWriter(out, columns)
        writer.writeheader()
        writer.writerows(rows)


def read(file):
    """Rows with numbers where cells are numbers; none if there is no such file."""
    if not file.exists():
        return []
    with open(file, newline="") as rows:
        return [{key: number(value) for key, value in row.items()} for row in csv.DictReader(rows)]


def number(text):
    try:
        return float(text)
    except (TypeError, ValueError):
        return text
