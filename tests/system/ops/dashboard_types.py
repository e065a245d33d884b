"""Grafana's dashboard as a TypeScript program, whose types are those of Grafana's own package: a misspelt key, a value
of a wrong type or one that an enumeration does not know is an error. Panels' options, which a dashboard may leave open,
are held against their plugins' types."""
import json
import pathlib
import re
import shutil
import subprocess

# Of Grafana's version 11, whose dashboards have the schemaVersion of ours.
PACKAGES = ["@grafana/schema@11.6.0", "typescript@5.8.3"]
PLUGINS = {"stat": "stat/panelcfg/x/StatPanelCfg_types.gen",
           "timeseries": "timeseries/panelcfg/x/TimeSeriesPanelCfg_types.gen"}
HEAD = """\
import type {{Dashboard, DataQuery, FieldConfig, Panel}} from "@grafana/schema";
{imports}
// As it stands in JSON: an enumeration's values instead of their names.
type Json<T> = T extends string ? `${{T}}` : T extends number | boolean | null | undefined ? T
  : T extends (infer U)[] ? Json<U>[] : T extends object ? {{[K in keyof T]: Json<T[K]>}} : T;
interface Query extends DataQuery {{ expr: string; legendFormat?: string; range?: boolean; instant?: boolean }}
"""


def install(folder):
    """Grafana's types and a compiler; why not, or nothing."""
    stamp = folder / "installed"
    if stamp.is_file() and stamp.read_text() == str(PACKAGES):
        return None
    if not shutil.which("npm"):
        return "no npm here"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    (folder / "package.json").write_text("{}")
    done = subprocess.run(["npm", "install", "--ignore-scripts", "--no-audit", "--no-fund", *PACKAGES], cwd=folder,
                          text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    if done.returncode != 0:
        return "npm cannot install Grafana's types: " + done.stdout.strip()[-200:].replace("\n", " ")
    stamp.write_text(str(PACKAGES))
    return None


def program(dashboard):
    """Each part with its type; what is open in Grafana's types goes into parts of its own."""
    lines = [HEAD.format(imports="\n".join(
        f'import type * as {name} from "@grafana/schema/dist/esm/raw/composable/{path}";'
        for name, path in PLUGINS.items()))]

    def part(name, kind, value):
        lines.append(f"export const {name}: Json<{kind}> = {json.dumps(value, indent=1)};\n")

    part("dashboard", 'Omit<Dashboard, "panels">', {key: value for key, value in dashboard.items() if key != "panels"})
    for panel in dashboard["panels"]:
        name, plugin = f"panel{panel['id']}", panel["type"]
        options, targets, defaults = panel["options"], panel["targets"], panel["fieldConfig"]["defaults"]
        part(name, 'Omit<Panel, "options" | "targets" | "fieldConfig">',
             {key: value for key, value in panel.items() if key not in ("options", "targets", "fieldConfig")})
        part(name + "_options", f"Partial<{plugin}.Options>", options)
        part(name + "_targets", "Query[]", targets)
        part(name + "_fields", 'Omit<FieldConfig, "custom">',
             {key: value for key, value in defaults.items() if key != "custom"})
        if "custom" in defaults:
            part(name + "_custom", f"{plugin}.FieldConfig", defaults["custom"])
    return "".join(lines)


def errors(folder, dashboard):
    """What the compiler says about it, each with the part that it is in."""
    text = program(dashboard)
    (folder / "dashboard.ts").write_text(text)
    done = subprocess.run(["node", "node_modules/typescript/lib/tsc.js", "--noEmit", "--strict", "--skipLibCheck",
                           "--moduleResolution", "node", "--target", "es2020", "--pretty", "false",
                           "dashboard.ts"], cwd=folder, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    if done.returncode == 0:
        return []
    parts = text.split("\n")
    found = []
    for line, what in re.findall(r"^dashboard\.ts\((\d+),\d+\): (.*)$", done.stdout, re.M):
        part = next(re.match(r"export const (\w+)", row).group(1) for row in reversed(parts[:int(line)])
                    if row.startswith("export const"))
        found.append(f"{part}: {parts[int(line) - 1].strip()}: {what}")
    return found or [done.stdout]
