# Many cases: every scan of a folder is baked, cut if a path is given, exported and checked. The same on a laptop and on
# a cluster (snakemake --cluster, --profile); stopped at any point, it goes on where it was.
#
#   snakemake -s scripts/cases.smk --cores 2 --config scans=scans out=out
#   snakemake -s scripts/cases.smk --cores 2 --config scans=scans out=out tool=round-014 path=cut.toml
#
# scans    a folder of STL, PLY, OBJ, OFF and 3MF meshes, and of case recipes (.toml; keep their parts in a folder below)
# out      where NAME.case, NAME.run, NAME.stl and NAME.json go, and report.csv with a line for each
# voxel    mm; without it the recipe's, or 0.1
# bake     more options of kerf bake, as "--close repair"
# tool, path   what to cut with, and along what; without them the closed scans are exported
# kerf     the program, default: the one in build/release/bin, else the one on the PATH
import json
import os
import re

here = os.path.dirname(os.path.abspath(workflow.snakefile))
built = os.path.join(here, "..", "build", "release", "bin", "kerf")
KERF = config.get("kerf", built if os.path.exists(built) else "kerf")
SCANS = config.get("scans")
OUT = config.get("out", "out/cases")
BAKE = (f"--voxel {config['voxel']} " if "voxel" in config else "") + str(config.get("bake", ""))
TOOL, PATH = config.get("tool"), config.get("path")
FORMATS = (".stl", ".ply", ".obj", ".off", ".3mf", ".toml")

if not SCANS or not os.path.isdir(SCANS):
    raise WorkflowError(f"no folder of scans: {SCANS}. Try: --config scans=FOLDER out=FOLDER")
if bool(TOOL) != bool(PATH):
    raise WorkflowError("tool and path belong together: --config tool=round-014 path=cut.toml")

inputs = {}
for name in sorted(os.listdir(SCANS)):
    stem, extension = os.path.splitext(name)
    if extension.lower() not in FORMATS:
        continue
    if stem in inputs:
        raise WorkflowError(f"{inputs[stem]} and {name} would both become {stem}.case. Try: rename one")
    inputs[stem] = os.path.join(SCANS, name)
if not inputs:
    raise WorkflowError(f"no meshes and no recipes in {SCANS}; expected files ending in {', '.join(FORMATS)}")


wildcard_constraints:
    name="|".join(map(re.escape, inputs)),


rule all:
    input:
        os.path.join(OUT, "report.csv"),


rule bake:
    input:
        lambda wildcards: inputs[wildcards.name],
    output:
        case=directory(os.path.join(OUT, "{name}.case")),
    params:
        kerf=KERF,
        options=BAKE,
    log:
        os.path.join(OUT, "log", "{name}.bake.txt"),
    shell:
        "{params.kerf:q} bake {input:q} -o {output.case:q} {params.options} >{log:q} 2>&1"


if TOOL:

    rule cut:
        input:
            case=os.path.join(OUT, "{name}.case"),
            path=PATH,
        output:
            run=directory(os.path.join(OUT, "{name}.run")),
        params:
            kerf=KERF,
            tool=TOOL,
        log:
            os.path.join(OUT, "log", "{name}.cut.txt"),
        shell:
            "{params.kerf:q} cut {input.case:q} --tool {params.tool:q} --path {input.path:q} -o {output.run:q} >{log:q} 2>&1"


rule export:
    input:
        os.path.join(OUT, "{name}.run" if TOOL else "{name}.case"),
    output:
        mesh=os.path.join(OUT, "{name}.stl"),
        check=os.path.join(OUT, "{name}.json"),
    params:
        kerf=KERF,
    log:
        os.path.join(OUT, "log", "{name}.export.txt"),
    shell:
        "{params.kerf:q} export {input:q} -o {output.mesh:q} >{log:q} 2>&1"
        " && {params.kerf:q} check {output.mesh:q} --json >{output.check:q} 2>>{log:q}"


rule report:
    input:
        expand(os.path.join(OUT, "{name}.json"), name=inputs),
    output:
        os.path.join(OUT, "report.csv"),
    run:
        with open(output[0], "w") as table:
            table.write("name,triangles,pieces,volume_mm3,area_mm2,is_print_ready\n")
            for name, path in zip(inputs, input):
                with open(path) as file:
                    check = json.load(file)
                numbers = [check.get(key, "") for key in ("triangles", "pieces", "volume_mm3", "area_mm2", "print_ready")]
                table.write(",".join([name] + [str(number) for number in numbers]) + "\n")
