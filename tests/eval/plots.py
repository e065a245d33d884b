"""Plots by gnuplot, as SVG."""
import subprocess

COLOURS = ["#4c566a", "#5e81ac", "#2a9d8f", "#bf8b2e", "#b5545b", "#7b5ea7", "#222222", "#88a05b"]


def lines(file, title, x_label, y_label, series, log_x=False, size="640,400"):
    """`series`: name -> (points, style), a style being gnuplot's (lines, points, linespoints)."""
    script = [f'set terminal svg size {size} background "white" font "sans,12"', f'set output "{file}"', "set grid lc rgb '#dddddd'",
              f'set title "{title}" noenhanced', f'set xlabel "{x_label}"', f'set ylabel "{y_label}"', "set yrange [0:*]",
              "set key outside right top noenhanced"]
    if log_x:
        script.append("set logscale x 2")
    parts = []
    for i, (name, (points, style)) in enumerate(series.items()):
        script += [f"$data{i} << EOD", *(f"{x} {y}" for x, y in sorted(points)), "EOD"]
        parts.append(f'$data{i} using 1:2 with {style} lw 2 pt 7 ps 0.5 lc rgb "{COLOURS[i % len(COLOURS)]}" title "{name}"')
    script.append("plot " + ", ".join(parts))
    subprocess.run(["gnuplot"], input="\n".join(script) + "\n", text=True, check=True)
