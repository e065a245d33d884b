"""Plots by gnuplot, as SVG."""
import subprocess

COLOURS = ["#4c566a", "#5e81ac", "#2a9d8f", "#bf8b2e", "#b5545b", "#7b5ea7", "#222222", "#88a05b"]


def panel(n, title, x_label, y_label, series, log_x=False, key="outside right top", y_range="0:*", dashed=(), x_step=None):
    """`series`: name -> (points, style), a style being gnuplot's (lines, points, linespoints); `dashed`: how names of those end that
    may lie on others. Unique `n`."""
    script = [f'set title "{title}" noenhanced', f'set xlabel "{x_label}"', f'set ylabel "{y_label}"', f"set yrange [{y_range}]",
              f"set key {key} Left reverse samplen 2 noenhanced", "set logscale x 2" if log_x else "unset logscale",
              f"set xtics {x_step}" if x_step else "set xtics autofreq"]
    parts = []
    for i, (name, (points, style)) in enumerate(series.items()):
        script += [f"$data{n}_{i} << EOD", *(f"{x} {y}" for x, y in sorted(points)), "EOD"]
        dashes = " dt 2" if style != "points" and name.endswith(tuple(dashed)) else ""
        parts.append(f'$data{n}_{i} using 1:2 with {style} lw 2{dashes} pt 7 ps 0.5 lc rgb "{COLOURS[i % len(COLOURS)]}" title "{name}"')
    return script + ["plot " + ", ".join(parts)]


def draw(file, size, script):
    head = [f'set terminal svg size {size} background "white" font "sans,12"', f'set output "{file}"', "set grid lc rgb '#dddddd'"]
    subprocess.run(["gnuplot"], input="\n".join(head + script) + "\n", text=True, check=True)


def lines(file, title, x_label, y_label, series, size="640,400", **kwargs):
    draw(file, size, panel(0, title, x_label, y_label, series, **kwargs))


def side_by_side(file, x_label, y_label, panels, size="900,360", **kwargs):
    """`panels`: title -> series."""
    script = [f"set multiplot layout 1,{len(panels)}"]
    for n, (title, series) in enumerate(panels.items()):
        script += panel(n, title, x_label, y_label, series, **kwargs)
    draw(file, size, script)
