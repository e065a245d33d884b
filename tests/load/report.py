"""What the experiments measured, as CSV, as a table and as a plot."""
import csv
import subprocess
import sys

COLUMNS = ["experiment", "policy", "tenant", "weight", "rate_hz", "share", "expected_share", "vbps", "vbps_alone", "p50_ms",
           "p50_alone_ms", "p99_ms", "p99_alone_ms", "slice_ms", "p99_allowed_ms", "jain"]


def text(value):
    return f"{value:.3f}" if isinstance(value, float) else str(value)


def write_csv(rows, file):
    with open(file, "w", newline="") as out:
        writer = csv.DictWriter(out, COLUMNS)
        writer.writeheader()
        writer.writerows({key: text(value) for key, value in row.items()} for row in rows)


def write_table(rows, file):
    cells = [COLUMNS] + [[text(row.get(column, "-")) for column in COLUMNS] for row in rows]
    widths = [max(len(line[i]) for line in cells) for i in range(len(COLUMNS))]
    lines = ["  ".join(cell.ljust(width) for cell, width in zip(line, widths)).rstrip() for line in cells]
    file.write_text("\n".join(lines) + "\n")


def blocks(folder):
    """One file of shares for each policy, one of latencies, as gnuplot reads them."""
    with open(folder / "shares.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    shares, latencies = {}, []
    for row in rows:
        if row["experiment"] == "shares":
            shares.setdefault(row["policy"], []).append(row)
        elif row["p99_alone_ms"]:
            latencies.append(row)
    return shares, latencies


def plot(folder):
    shares, latencies = blocks(folder)
    script = [f'set terminal pngcairo size 1200,480; set output "{folder / "shares.png"}"',
              "set multiplot layout 1,2; set style fill solid 0.8; set boxwidth 0.9 relative; set grid y",
              "set style data histograms; set style histogram clustered gap 1; set yrange [0:*]",
              "set key top left; set xtics rotate by -20"]
    plots = []
    if shares:
        policies = list(shares)
        script.append("$shares << EOD")
        for i, row in enumerate(shares[policies[0]]):
            line = [f'"weight {row["weight"]}"', row["expected_share"]] + [shares[p][i]["share"] for p in policies]
            script.append(" ".join(line))
        script.append("EOD")
        series = ['$shares using 2:xtic(1) title "by weight" lc rgb "#999999"']
        series += [f'$shares using {i + 3} title "{p}" noenhanced' for i, p in enumerate(policies)]
        plots.append('set title "Share of the device, all tenants flooding"\nplot ' + ", ".join(series))
    if latencies:
        script.append("$latencies << EOD")
        script += [f'"{row["experiment"]}, {row["policy"].replace("_", " ")}" {row["p99_alone_ms"]} {row["p99_ms"]}'
                   for row in latencies]
        script.append("EOD")
        plots.append('set logscale y; set yrange [1:*]; set title "A steady client\'s p99 latency, ms"\n'
                     'plot $latencies using 2:xtic(1) title "alone", $latencies using 3 title "beside a flood"')
    subprocess.run(["gnuplot"], input="\n".join(script + plots) + "\n", text=True, check=True)


def check_roughly(rows):
    """What must hold on the busiest machine: shares are ratios."""
    wrong = [f'{row["tenant"]}: share {row["share"]:.3f}, by weight {row["expected_share"]:.3f}' for row in rows
             if row["policy"] == "fair" and "expected_share" in row
             and abs(row["share"] - row["expected_share"]) > 0.05]
    wrong += [f'{row["tenant"]}: Jain {row["jain"]:.3f}' for row in rows
              if row["experiment"] == "equal" and row["jain"] < 0.97]
    if wrong:
        sys.exit("shares are not what the policy promises:\n  " + "\n  ".join(wrong))
