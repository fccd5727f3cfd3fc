# Many cases: every scan of a folder is baked, cut if a path is given, exported and checked. The same on a laptop and on
# a cluster (--profile); for Snakemake 7 and 8; stopped at any point, it goes on where it was. scripts/cases starts it:
#
#   scripts/cases scans out
#   scripts/cases scans out tool=round-014 path=cut.toml
#
# scans    a folder of STL, PLY, OBJ, OFF and 3MF meshes, and of case recipes (.toml; keep their parts in a folder below)
# out      where NAME.case, NAME.run, NAME.stl and NAME.json go, and report.csv with a line for each: numbers of the result,
#          why it failed, warnings, unit, how many vertices of the scan are not in the result, what closing changed
# voxel    mm; without it the recipe's, or 0.1
# bake     more options of kerf bake, as "--close repair"
# tool, path   what to cut with, and along what; without them the closed scans are exported. A folder as path holds a path
#          file for each scan: NAME.toml or NAME.csv
# mem_mb, runtime   memory and time for one scan, MB and minutes: 60 minutes, and 4000 MB at voxels of 0.1 mm (their square,
#          1000 MB at least). Measured: 0.2 to 0.5 GB for a jaw at 0.1 mm, half a minute to one.
# memory   MB that all scans of this machine may need together; scripts/cases passes it on to Snakemake
# watch    a file with the paths of the scans that are ready: others do not count yet (scripts/cases --watch)
# kerf     the program, default: the one in build/release/bin, else the one on the PATH
#
# A scan that fails does not stop the others: its line in report.csv says at which step and why, out/log has all of it,
# and the whole ends with an error. Started again, it tries only those that failed (or changed); with watch, those that
# changed.
#
# Snakemake 7 on Python 3.12 and newer drops blanks inside the braces of an f-string: none here may count.
import csv
import difflib
import json
import os
import re
import sys
import tomllib

here = os.path.dirname(os.path.abspath(workflow.main_snakefile))
built = os.path.join(here, "..", "build", "release", "bin", "kerf")
KERF = config.get("kerf", built if os.path.exists(built) else "kerf")
SCANS = config.get("scans")
OUT = config.get("out", "out/cases")
REPORT = os.path.join(OUT, "report.csv")
ROWS = os.path.join(OUT, "log", ".rows")
BAKE = (f"--voxel {config['voxel']} " if "voxel" in config else "") + str(config.get("bake", ""))
TOOL, PATH = config.get("tool"), config.get("path")
VOLUMES = (".nii", ".nii.gz", ".nrrd", ".nhdr", ".mha", ".mhd", ".dcm")
FORMATS = (".stl", ".ply", ".obj", ".off", ".3mf", ".toml")
KEYS = ("scans", "out", "voxel", "bake", "tool", "path", "mem_mb", "runtime", "memory", "watch", "kerf")

# A key that is passed over silently, or a number that is none, would be found out thirty scans later.
for key in config:
    if key not in KEYS:
        near = difflib.get_close_matches(key, KEYS, 1)
        raise WorkflowError(f"no key \"{key}\"; expected one of {', '.join(KEYS)}." + (f" Try: {near[0]}=" if near else ""))
for key in ("voxel", "mem_mb", "runtime", "memory"):
    try:
        if not float(config.get(key, 1)) > 0 or key != "voxel" and int(float(config.get(key, 1))) < 1:
            raise ValueError
    except (TypeError, ValueError, OverflowError):
        raise WorkflowError(f"{key}={config[key]}: " + ("no number above 0. Try: a decimal point, as in voxel=0.2"
                            if key == "voxel" else f"no whole number above 0. Try: {key}=60")) from None

if not SCANS or not os.path.isdir(SCANS):
    raise WorkflowError(f"no folder of scans: {SCANS}. Try: --config scans=FOLDER out=FOLDER")
if bool(TOOL) != bool(PATH):
    raise WorkflowError("tool and path belong together: --config tool=round-014 path=cut.toml")

ready = None
if "watch" in config:
    with open(config["watch"]) as file:
        ready = set(map(os.path.normpath, file.read().splitlines()))


def made_from(stem):
    """The scan of an earlier result, as its log names it."""
    try:
        with open(os.path.join(OUT, "log", stem + ".txt"), errors="replace") as file:
            return file.readline().split("== kerf bake ")[1].split(" -o ")[0]
    except (OSError, IndexError):
        return ""


# With watch, a scan that nobody can do stops no other: it is left out, and why.
inputs, left_out, not_done = {}, [], {}
for name in sorted(os.listdir(SCANS)):
    stem, extension = os.path.splitext(name)
    if ready is not None and os.path.normpath(os.path.join(SCANS, name)) not in ready:
        continue
    if extension.lower() not in FORMATS:
        if os.path.isfile(os.path.join(SCANS, name)) and not name.startswith("."):
            left_out.append(name)
        continue
    if stem in inputs and ready is not None:
        here, before = os.path.join(SCANS, name), inputs[stem]
        if made_from(stem) == here:
            inputs[stem], here = here, before
        not_done[os.path.basename(here)] = f"{inputs[stem]} and {here} would both become {stem}.case. Try: rename one"
        continue
    if stem in inputs:
        raise WorkflowError(f"{inputs[stem]} and {name} would both become {stem}.case. Try: rename one")
    inputs[stem] = os.path.join(SCANS, name)
if not inputs and ready is None:
    raise WorkflowError(f"no meshes and no recipes in {SCANS}; expected files ending in {', '.join(FORMATS)}")


def say(sentence):
    print(f"cases: {sentence}", file=sys.stderr, flush=True)


def unused_files():
    """A scan that is in no line of the report would be missed by nobody. What a recipe names is in that one's."""
    parts = {os.path.realpath(part) for scan in inputs.values() for part in parts_of(scan)}
    return [name for name in left_out if os.path.realpath(os.path.join(SCANS, name)) not in parts]


def say_what_is_left_out():
    for why in not_done.values():
        say(f"left out: {why}")
    unused = unused_files()
    if not unused:
        return
    has_volume = any(name.lower().endswith(VOLUMES) for name in unused)
    names = "its name" if len(unused) == 1 else "their names"
    say(f"left out, no mesh and no recipe by {names}: {', '.join(unused)}."
        + (" A volume takes a recipe that says what its labels are: docs/reference/recipes.md" if has_volume else ""))


# A result that somebody deleted is made again. A scan that failed has none: its row is for the report to take away. All of
# this file is read anew by every job, the report's too.
for name in inputs:
    row = os.path.join(OUT, "log", name + ".row")
    if os.path.exists(os.path.join(OUT, name + ".stl")) or not os.path.exists(row):
        continue
    with open(row) as file:
        is_done = file.read().split()[-1:] == ["0"]
    if is_done:
        os.remove(row)


def parts_of(recipe):
    """The files a recipe names, as far as they exist: where one changes, the case is baked again."""
    if not recipe.endswith(".toml"):
        return []
    try:
        with open(recipe, "rb") as file:
            table = tomllib.load(file)
        named = [part["mesh"] for part in table.get("part", []) if "mesh" in part]
        named += table.get("outline", {}).get("meshes", []) + [table.get("labels", {}).get("volume", "")]
        paths = {os.path.join(os.path.dirname(recipe), name) for name in named if name}
    except (OSError, ValueError, TypeError, AttributeError):  # kerf will say what is wrong with it
        return []
    files = {path for path in paths if os.path.isfile(path)}
    for folder in filter(os.path.isdir, paths):  # of slices
        files |= {entry.path for entry in os.scandir(folder) if entry.is_file()}
    return sorted(files)


def both_paths(found, name):
    return f"{found[0]} and {found[1]} are both the path of {name}. Try: rename one"


def path_of(name):
    """Of a folder of paths, that of this scan; kerf cut names the file if there is none."""
    if not PATH or not os.path.isdir(PATH):
        return PATH or ""
    found = [path for end in (".toml", ".csv") if os.path.isfile(path := os.path.join(PATH, name + end))]
    if len(found) > 1:
        raise WorkflowError(both_paths(found, name))
    return found[0] if found else os.path.join(PATH, name + ".toml")


def need_mb(name):
    """Of one scan. The field has a layer of voxels along the surface."""
    voxel = config.get("voxel")
    if voxel is None and inputs[name].endswith(".toml"):
        try:
            with open(inputs[name], "rb") as file:
                voxel = float(tomllib.load(file)["voxel"])
        except (OSError, ValueError, KeyError, TypeError):  # kerf will say what is wrong with it
            pass
    voxel = float(voxel or 0.1)
    return int(float(config.get("mem_mb") or max(1000, 4000 * (0.1 / (voxel if voxel > 0.001 else 0.001)) ** 2)))


if ready is not None:
    for name in list(inputs):
        # Parts below the folder still grow: the next look has them.
        folder = os.path.normpath(SCANS) + os.sep
        if any(part.startswith(folder) and part not in ready for part in map(os.path.normpath, parts_of(inputs[name]))):
            del inputs[name]
            continue
        try:
            path_of(name)
        except WorkflowError as why:
            not_done[os.path.basename(inputs.pop(name))] = str(why)


wildcard_constraints:
    name="|".join(map(re.escape, inputs)),


localrules:
    report,


# One job for a scan. It succeeds even where kerf fails, and leaves a row with the last step and its exit code. One after
# the other says how many rows there are: how many there will be is in a file, or another scan would change the rule.
rule scan:
    input:
        scan=lambda wildcards: inputs[wildcards.name],
        parts=lambda wildcards: parts_of(inputs[wildcards.name]),
        path=lambda wildcards: list(filter(os.path.isfile, [path_of(wildcards.name)])) or ([PATH] if PATH else []),
    output:
        row=os.path.join(OUT, "log", "{name}.row"),
    params:
        kerf=KERF,
        bake=BAKE,
        tool=TOOL or "",
        path=lambda wildcards: path_of(wildcards.name),
        cuts="true" if TOOL else "false",
        case=os.path.join(OUT, "{name}.case"),
        run=os.path.join(OUT, "{name}.run"),
        mesh=os.path.join(OUT, "{name}.stl"),
        check=os.path.join(OUT, "{name}.json"),
        rows=ROWS,
    resources:
        mem_mb=lambda wildcards: need_mb(wildcards.name),
        runtime=int(float(config.get("runtime", 60))),
    log:
        os.path.join(OUT, "log", "{name}.txt"),
    shell:
        """
        exec 3>&2 >{log:q} 2>&1
        rm -f {params.mesh:q} {params.check:q}
        step() {{ step=$1; echo "== kerf $*" >&2; {params.kerf:q} "$@"; }}
        bake() {{ step bake {input.scan:q} -o {params.case:q} {params.bake} "$@"; }}
        scan() {{
            # Without --overwrite a case that is up to date is left alone; one of other settings is baked again.
            if [ -e {params.case:q} ]; then bake || bake --overwrite; else bake; fi || return
            result={params.case:q}
            if {params.cuts}; then
                result={params.run:q}
                step cut {params.case:q} --tool {params.tool:q} --path {params.path:q} -o "$result" --overwrite || return
            fi
            step export "$result" -o {params.mesh:q} --overwrite || return
            step check {params.mesh:q} --json >{params.check:q}
        }}
        code=0
        scan || code=$?
        if [ "$code" = 0 ]; then said=done; else said="$step failed"; fi
        {{
            flock 4
            echo "$step $code" >{output.row:q}
            all=0 ended=0
            while IFS= read -r row; do
                all=$((all + 1))
                [ ! -e "$row" ] || ended=$((ended + 1))
            done <{params.rows:q}
            echo "cases: $ended of $all: "{wildcards.name:q}": $said" >&3
        }} 4>>{params.rows:q}.lock
        """


def reason(name, step, code):
    """What kerf said last, in one line."""
    if step == "check":
        with open(os.path.join(OUT, name + ".json")) as file:
            return "; ".join(json.load(file)["reasons"])
    with open(os.path.join(OUT, "log", name + ".txt"), errors="replace") as file:
        said = [line.strip() for line in file if line.startswith("kerf: ")]
    return said[-1].removeprefix("kerf: ") if said else f"no word from kerf; it ended with {code}"


def warnings_of(name):
    """What kerf warned of, in one line: what went well by its exit code may still not be what was scanned."""
    with open(os.path.join(OUT, "log", name + ".txt"), errors="replace") as file:
        said = [line.strip().removeprefix("kerf: ") for line in file if re.search("WARNING|CHECK TH", line)]
    return "; ".join(dict.fromkeys(said))


def told_by_case(name):
    """Of its manifest: unit, vertices of the scan that are not in the result, what closing changed."""
    try:
        with open(os.path.join(OUT, name + ".case", "case.toml"), "rb") as file:
            case = tomllib.load(file)
        close = case["close"]
        units = "; ".join(dict.fromkeys(source["unit"] for source in case.get("source", []) if source.get("unit")))
        lost = close.get("numbers", {}).get("vertices_lost")
        return [units, "" if lost is None else int(lost), "; ".join(close.get("changes", []))]
    except (OSError, ValueError, KeyError, TypeError, AttributeError):  # kerf has said what is wrong with it
        return ["", "", ""]


# Without an output: it runs every time, and nothing of it is taken away when it says that something failed.
rule report:
    default_target: True
    input:
        expand(os.path.join(OUT, "log", "{name}.row"), name=inputs),
    run:
        keys = ("triangles", "pieces", "volume_mm3", "area_mm2", "print_ready")
        text_of = lambda v: str(v).lower() if isinstance(v, bool) else f"{v:.3f}" if isinstance(v, float) else v
        failed, warned = [], []
        with open(os.path.join(OUT, "report.csv.part"), "w", newline="") as file:
            table = csv.writer(file, lineterminator="\n")
            table.writerow(["name", "status", *keys[:-1], "is_print_ready", "reason", "warnings", "unit", "vertices_lost", "changes"])
            for name, row in zip(inputs, input):
                step, code = open(row).read().split()
                warnings = warnings_of(name)
                if warnings:
                    warned.append(name)
                if code == "0":
                    with open(os.path.join(OUT, name + ".json")) as check:
                        numbers = json.load(check)
                    values = [text_of(numbers.get(key, "")) for key in keys]
                    table.writerow([name, "ok", *values, "", warnings, *told_by_case(name)])
                else:
                    failed.append(row)
                    empty = ["" for key in keys]
                    table.writerow([name, step + " failed", *empty, reason(name, step, code), warnings, "", "", ""])
        os.replace(file.name, REPORT)
        say_what_is_left_out()
        if warned:
            say(f"WARNINGS about {len(warned)} of {len(inputs)}: {', '.join(warned)}. What: {REPORT}")
        for row in failed if ready is None else []:  # to be tried again next time
            os.remove(row)


ran = []  # rows of the scans of this run


onstart:
    if os.path.exists(REPORT):  # a run that is stopped leaves none rather than an old one
        os.remove(REPORT)
    ran.clear()
    # Old rows of what is to be done again would be counted; Snakemake itself takes each away only when its job begins.
    for job in workflow.persistence.dag.needrun_jobs():
        for row in job.output if job.rule.name == "scan" else []:
            ran.append(row)
            if os.path.exists(row):
                os.remove(row)
    os.makedirs(os.path.dirname(ROWS), exist_ok=True)
    with open(ROWS + ".part", "w") as file:
        file.writelines(os.path.join(OUT, "log", name + ".row") + "\n" for name in inputs)
    os.replace(file.name, ROWS)
    if "memory" in config and ran:
        most, need = int(float(config["memory"])), max(map(need_mb, inputs))
        if need > most:
            say(f"one scan may need {need} MB, and only {most} MB are free: one at a time. "
                "Try: larger voxels, or mem_mb= with a measured number")
        elif most // need < min(len(ran), getattr(workflow, "cores", None) or os.cpu_count()):
            say(f"{most // need} at a time: {need} MB each of {most} MB (mem_mb= and memory= change it)")


# Scans that failed are no error of the workflow, which would be told in Snakemake's words. It is over, and kept nothing back.
onsuccess:
    if os.path.exists(REPORT) and inputs:  # none where only some rules were asked for
        with open(REPORT, newline="") as file:
            rows = list(csv.DictReader(file))
        failed = [row["name"] for row in rows if row["status"] != "ok"]
        done, skipped = len(rows) - len(failed), len(unused_files()) + len(not_done)
        files = "file" if skipped == 1 else "files"
        for row in [row for row in rows if row["status"] != "ok"][:10]:
            scan = inputs[row["name"]]
            say(f"{scan}: {row['status']}: {row['reason'].removeprefix(scan + ': ')}")
        if len(failed) > 10:
            say(f"and {len(failed) - 10} more: {REPORT}")
        say(f"{done} done, {len(rows) - len(ran)} of the {len(rows)} earlier; {len(failed)} failed; "
            f"{skipped} {files} left out")
        if not_done:
            say(f"{len(not_done)} left out for a reason above: {', '.join(not_done)}")
        if failed:
            say(f"{len(failed)} of {len(rows)} failed: {', '.join(failed)}. "
                f"Reasons: {REPORT}; logs: {os.path.join(OUT, 'log')}. "
                + ("Started again, Kerf tries only these." if ready is None else "Kerf tries each when it changes."))
            os._exit(1)
        say(f"{len(rows)} of {len(rows)} done: {REPORT}")


onerror:  # such as a job that a scheduler killed
    rows = [os.path.join(OUT, "log", name + ".row") for name in inputs]
    say(f"stopped: {sum(map(os.path.exists, rows))} of {len(rows)} ended, no report. Started again, it goes on")
