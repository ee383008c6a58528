"""The command line: it only translates; everything it does is a Python function too.

Nothing heavy is imported before a command runs, so that help and completion answer at once.
"""

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

_NOT_READ = 141  # exit code, 128 + SIGPIPE, as shells report it
app = typer.Typer(
    name="ballesta",
    help="Finite-element structural and fatigue checks of machine parts under the loads of their "
    "mechanism's cycle.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)


def _version(asked: bool) -> None:
    if asked:
        from ballesta.pipeline import versions

        print(*(f"{name} {number}" for name, number in versions().items()), sep="\n")
        raise typer.Exit


@app.callback()
def _main(
    version: Annotated[
        bool,
        typer.Option("--version", callback=_version, is_eager=True, help="print versions and exit"),
    ] = False,
) -> None:
    """Options of the command line itself."""


Designs = Annotated[list[Path], typer.Argument(metavar="DESIGN...", help="design files (TOML)")]
OneDesign = Annotated[Path, typer.Argument(metavar="DESIGN", help="a design file (TOML)")]
Fields = Annotated[
    bool,
    typer.Option(
        "--fields", help="mesh every part, also where no check needs it, to show its stress"
    ),
]
Overrides = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="override a value, e.g. parts.bar.wall=5mm"),
]
Accuracy = Annotated[
    str | None,
    typer.Option(
        "--accuracy", help="numerical error to refine meshes to, such as 5%; else the file's"
    ),
]
Fidelity = Annotated[
    str,
    typer.Option(
        "--fidelity",
        metavar="RUNG",
        help="formula, solid, or auto: the cheapest that settles each part",
    ),
]
Within = Annotated[
    str | None,
    typer.Option(
        "--within",
        metavar="TIME",
        help="time limit of a check, e.g. 60s; ends with the models finished by then",
    ),
]
Store = Annotated[
    Path | None,
    typer.Option(
        "--store",
        metavar="DIR",
        envvar="BALLESTA_STORE",
        help="folder that keeps loads, meshes and solutions for later checks",
    ),
]
NoStore = Annotated[
    bool, typer.Option("--no-store", help="use no store, even if BALLESTA_STORE names one")
]
Out = Annotated[Path, typer.Option("--out", help="folder for reports")]
Json = Annotated[bool, typer.Option("--json", help="print the result as JSON")]


@app.command()
def check(
    designs: Designs,
    out: Out = Path("out"),
    json: Annotated[bool, typer.Option("--json", help="print the results as a JSON list")] = False,
    overrides: Overrides = None,
    accuracy: Accuracy = None,
    fidelity: Fidelity = "auto",
    within: Within = None,
    fields: Fields = False,
    baseline: Annotated[
        bool, typer.Option("--write-baseline", help="write NAME.baseline.json beside each design")
    ] = False,
    store: Store = None,
    no_store: NoStore = False,
    pdf: Annotated[
        bool, typer.Option("--pdf", help="also print report.pdf, by the browser that is there")
    ] = False,
    verbose: Annotated[
        bool, typer.Option("--verbose", "-v", help="print all checks, warnings and assumptions")
    ] = False,
) -> None:
    """Check designs and write report.html, result.json and a .vtu file per part.

    Exit code 0: every part passes; 1: a part fails or stays undecided; 2: an input is wrong;
    3: the numerics gave up. Of several designs the highest counts. 130: stopped by Ctrl-C, what was
    finished is written.
    """
    from ballesta.run import check_all

    wanted = [] if accuracy is None else [f"accuracy={accuracy}"]
    wanted = [*(overrides or []), *wanted]
    code = check_all(
        designs,
        out=out,
        as_json=json,
        overrides=wanted,
        baseline=baseline,
        fidelity=fidelity,
        within=within,
        store=None if no_store else store,
        fields=fields,
        pdf=pdf,
        verbose=verbose,
    )
    raise typer.Exit(code)


@app.command()
def batch(
    designs: Annotated[
        list[Path], typer.Argument(metavar="DESIGN...", help="design files, or folders of them")
    ],
    out: Annotated[Path, typer.Option("--out", help="folder of the batch; resumed if it is one")],
    jobs: Annotated[
        int | None, typer.Option("--jobs", metavar="N", help="designs at a time; else one per core")
    ] = None,
    sweeps: Annotated[
        list[str] | None,
        typer.Option(
            "--sweep", help="vary a value: 'parts.bar.wall = 4..8 mm : 9'; may be given again"
        ),
    ] = None,
    sample: Annotated[
        int | None,
        typer.Option(
            "--sample", metavar="N", help="N points of a Sobol sequence, not the sweeps' grid"
        ),
    ] = None,
    seed: Annotated[int, typer.Option("--seed", help="seed of the sample")] = 0,
    until: Annotated[
        str | None,
        typer.Option(
            "--until",
            metavar="pass",
            help="search one --sweep for the value that just passes: pass, or 'pass of PART, PART'",
        ),
    ] = None,
    fidelity: Annotated[
        str,
        typer.Option(
            "--fidelity",
            metavar="RUNG",
            help="as for check; or swept: solids on meshes carried over from a neighbour",
        ),
    ] = "auto",
    within: Within = None,
    accuracy: Accuracy = None,
    time_limit: Annotated[
        str,
        typer.Option("--time-limit", metavar="TIME", help="stop a design after it; none: never"),
    ] = "600s",
    memory: Annotated[
        str | None,
        typer.Option("--memory", metavar="SIZE", help="stop a design that takes more, e.g. 4GB"),
    ] = None,
    overrides: Overrides = None,
    reports: Annotated[
        bool | None,
        typer.Option(
            "--reports/--no-reports", help="a report.html each; else for up to 50 designs"
        ),
    ] = None,
    store: Annotated[
        Path | None,
        typer.Option(
            "--store", metavar="DIR", envvar="BALLESTA_STORE", help="as for check; else OUT/store"
        ),
    ] = None,
    no_store: Annotated[
        bool, typer.Option("--no-store", help="use no store: nothing is shared")
    ] = False,
    executor: Annotated[
        str,
        typer.Option(
            "--executor", metavar="WHERE", help="local, or dask://HOST:PORT for a cluster's workers"
        ),
    ] = "local",
    tls: Annotated[
        Path | None,
        typer.Option(
            "--tls", metavar="DIR", help="folder of certificates for --executor tls://HOST:PORT"
        ),
    ] = None,
) -> None:
    """Check many designs and their variations side by side; write index.html and tables.

    The same command resumes a batch that was stopped or killed. Each finished design is one
    line; one that crashes, hangs or takes too much memory harms no other.

    Exit code: the highest of the designs; 0 pass, 1 FAIL or UNDECIDED, 2 wrong input, 3 gave up,
    crashed, out of time or memory; 130 stopped.
    """
    from ballesta.commands.batch_command import Wanted, run_batch_command

    wanted = Wanted(
        out=out,
        jobs=jobs,
        sweeps=tuple(sweeps or ()),
        sample=sample,
        seed=seed,
        until=until,
        fidelity=fidelity,
        within=within,
        accuracy=accuracy,
        time_limit=time_limit,
        memory=memory,
        overrides=tuple(overrides or ()),
        reports=reports,
        store=store,
        no_store=no_store,
        executor=executor,
        tls=tls,
    )
    raise typer.Exit(run_batch_command(designs, wanted))


@app.command()
def loads(
    design: OneDesign,
    csv: Annotated[
        str | None,
        typer.Option("--csv", metavar="FILE", help="write the whole history; - is standard output"),
    ] = None,
    plot: Annotated[
        bool, typer.Option("--plot", help="write OUT/DESIGN/loads.html, with a moving picture")
    ] = False,
    cycle: Annotated[
        list[str] | None,
        typer.Option("--cycle", metavar="NAME", help="only this cycle or run; may be given again"),
    ] = None,
    out: Out = Path("out"),
    json: Json = False,
    overrides: Overrides = None,
) -> None:
    """Solve the cycles of a design: reactions, efforts, drive and contacts, and their validity.

    For a measured run, report the loads on each body and their balance.

    Exit code 0: the loads are computed, even if a validity check fails; 2: an input is wrong;
    3: the numerics gave up.
    """
    from ballesta.commands.loads_command import Wanted, run_loads

    wanted = Wanted(csv, plot, tuple(cycle or ()), out, json)
    raise typer.Exit(run_loads(design, wanted, overrides or []))


@app.command()
def diff(
    before: Annotated[
        Path, typer.Argument(metavar="A", help="a design file, a result.json or a folder of a run")
    ],
    after: Annotated[Path, typer.Argument(metavar="B", help="the other one, of the same kinds")],
    html: Annotated[
        Path | None, typer.Option("--html", metavar="FILE", help="write every change as a page")
    ] = None,
    json: Json = False,
    fidelity: Fidelity = "auto",
    within: Within = None,
) -> None:
    """Compare A with B: verdicts, then inputs, loads, stresses, safety, masses.

    Design files are checked first; of the folders of two runs all results are compared.

    Exit code 0: compared, whatever changed; 2: an input is wrong; 3: the numerics gave up.
    """
    from ballesta.diff.difference import Wanted, run_diff

    raise typer.Exit(run_diff(before, after, Wanted(html, json, fidelity, within)))


@app.command()
def why(
    target: Annotated[
        Path,
        typer.Argument(metavar="DESIGN", help="a design file, a result.json or a folder of a run"),
    ],
    part: Annotated[
        str, typer.Argument(metavar="PART", help="a part; else the deciding check")
    ] = "",
    kinds: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[KIND...]", help="kinds of its checks: static, fatigue, buckling, ..."
        ),
    ] = None,
    every: Annotated[
        bool,
        typer.Option(
            "--all", help="all checks of these kinds, not only the one nearest to its limit"
        ),
    ] = False,
    verbose: Annotated[
        bool, typer.Option("--verbose", "-v", help="print every symbol, formula and unit load")
    ] = False,
    json: Annotated[bool, typer.Option("--json", help="print the checks as a JSON list")] = False,
    overrides: Overrides = None,
    fidelity: Annotated[
        str | None, typer.Option("--fidelity", metavar="RUNG", help="models, as for check")
    ] = None,
    store: Store = None,
) -> None:
    """Explain the number of a check: forces, stresses, formulas, limit, verdict.

    A design file is checked first; an existing result is only read.

    Exit code 0: explained, whatever the verdict; 2: an input is wrong; 3: the numerics gave up.
    """
    from ballesta.commands.why import Wanted, run_why

    wanted = Wanted(part, tuple(kinds or ()), every, verbose, json)
    raise typer.Exit(run_why(target, wanted, tuple(overrides or ()), fidelity, store))


@app.command()
def show(
    design: OneDesign,
    part: Annotated[
        str | None, typer.Argument(metavar="PART", help="the part to begin with")
    ] = None,
    off_screen: Annotated[
        Path | None,
        typer.Option("--off-screen", metavar="FILE", help="write a PNG instead of a window"),
    ] = None,
    fidelity: Fidelity = "auto",
    within: Within = None,
    fields: Fields = False,
    overrides: Overrides = None,
    store: Store = None,
    no_store: NoStore = False,
) -> None:
    """Check a design and open a window with the stress of its parts at every position.

    Exit code 0: shown, whatever the checks say; 2: an input is wrong, or there is no display;
    3: the numerics gave up, or graphics libraries are missing (the message names them).
    """
    from ballesta.commands.show import Wanted, run_show

    wanted = Wanted(part, off_screen, fidelity, within, None if no_store else store, fields)
    raise typer.Exit(run_show(design, wanted, overrides or []))


@app.command()
def improve(
    design: OneDesign,
    verify: Annotated[
        bool, typer.Option("--verify", help="check each listed change by the models that decided")
    ] = False,
    apply: Annotated[
        bool, typer.Option("--apply", help="write the first change that passes into the file")
    ] = False,
    fidelity: Fidelity = "auto",
    json: Json = False,
    overrides: Overrides = None,
) -> None:
    """Find single changes that make a design pass, or save mass where it does.

    Each dimension of the parts and their materials are tried by formula, set against the models
    that decided; --verify and --apply check the changes by these models.

    Exit code 0: it passes, or a change makes each open part pass; 1: none does; 2: an input is
    wrong; 3: the numerics gave up.
    """
    from ballesta.commands.improve_command import Wanted, run_improve

    wanted = Wanted(verify or apply, apply, fidelity, json)
    raise typer.Exit(run_improve(design, wanted, overrides or []))


@app.command()
def plan(design: OneDesign, overrides: Overrides = None) -> None:
    """Preview a check without solving it: parts, loads, unknowns, time and memory."""
    from ballesta.commands.plan import plan_text
    from ballesta.run import guarded

    raise typer.Exit(guarded(lambda: print(plan_text(design, overrides or []))))


@app.command()
def export(
    design: OneDesign,
    part: Annotated[str, typer.Option("--part", metavar="NAME", help="the part to write")],
    at: Annotated[
        str, typer.Option("--at", metavar="POSITION", help="worst, or a position as shown")
    ] = "worst",
    pvd: Annotated[
        bool, typer.Option("--pvd", help="instead write the volume at every position for ParaView")
    ] = False,
    cycle: Annotated[
        str | None, typer.Option("--cycle", metavar="NAME", help="the cycle of the position")
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(
            "--out", metavar="FILE", help="the deck, of --pvd the folder; else in out/DESIGN"
        ),
    ] = None,
    overrides: Overrides = None,
) -> None:
    """Write a part at one position for CalculiX and PrePoMax, or over its cycles for ParaView.

    Exit code 0: written; 2: an input is wrong; 3: the numerics gave up.
    """
    from ballesta.commands.export import run_export

    position = None if pvd else at
    raise typer.Exit(
        run_export(design, part, position, cycle=cycle, out=out, overrides=overrides or [])
    )


@app.command()
def new(
    template: Annotated[str, typer.Argument(help="name of the machine to start from")] = "",
    file: Annotated[
        Path | None, typer.Option("--file", help="write to this new file instead of printing")
    ] = None,
) -> None:
    """Print a commented design file to start from; without a name, list the templates."""
    from ballesta.run import write_new

    raise typer.Exit(write_new(template, file))


@app.command()
def materials(
    name: Annotated[str, typer.Argument(help="a material, to see all of its values")] = "",
) -> None:
    """List the materials that ballesta knows, or all values of one and where they are from."""
    from ballesta.design.authoring import materials_text
    from ballesta.run import guarded

    raise typer.Exit(guarded(lambda: print(materials_text(name))))


@app.command()
def schema(
    result: Annotated[bool, typer.Option("--result", help="the schema of result.json")] = False,
) -> None:
    """Print the JSON schema of design files, for editors; or of result.json, for programs."""
    import json as json_module

    if result:
        from reports.files import result_schema as wanted
    else:
        from ballesta.design.authoring import design_schema as wanted

    print(json_module.dumps(wanted(), indent=2))


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit code when called from Python with arguments.

    Without arguments it is the program, of which `ballesta.__main__` runs long commands.
    """
    from ballesta.supervisor import claim_standard_output, finish_standard_output, speak_utf8
    from fem.threads import one_thread, policy

    speak_utf8()
    if argv is None:
        claim_standard_output()
    try:
        policy()
    except ValueError as error:
        print(f"ballesta: environment: {error}", file=sys.stderr)
        return 2
    try:
        with one_thread():
            app(args=None if argv is None else list(argv), standalone_mode=True)
    except SystemExit as stop:
        if isinstance(stop.__context__, BrokenPipeError):  # `head` has enough: for typer that is 1
            stop.code = _NOT_READ
        if argv is None:
            raise
        return int(stop.code or 0)
    finally:
        if argv is None:
            finish_standard_output()
    return 0
