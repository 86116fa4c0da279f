"""The pytest plugin: verdicts become tests of a user's own suite. See docs/pytest.md.

pytest loads this module in every session where the package is installed: it imports nothing of the suite before an
option or a marker asks for it.
"""

from __future__ import annotations

import sys
from collections.abc import Generator
from typing import TYPE_CHECKING, Any

import pytest

from crosscheck.pytest_plugin.names import ENGINE, FIXTURE, MARKER, OUTCOME

if TYPE_CHECKING:
    from crosscheck.pytest_plugin import cases
    from crosscheck.verdict import Verdict

_MEANING = (
    "crosscheck(engine, checks=None, tier='quick', seed=0, needed=None, allow_inconclusive=None): "
    "judge an engine by particle-crosscheck, a test for each case; see docs/pytest.md"
)
#: Mistakes in markers, told together, once all tests are collected.
_MISTAKES: pytest.StashKey[list[str]] = pytest.StashKey()
_NO_CASE = f"only functions, and methods of plain classes, take the marker {MARKER}"
#: What --crosscheck-engine asks for.
_SETTINGS: pytest.StashKey[cases.Settings] = pytest.StashKey()
#: Key of what the workers of pytest-xdist are told of the time that there is.
_TIMES = "crosscheck_times"


def pytest_addoption(parser: pytest.Parser) -> None:
    """The options, all of which begin with --crosscheck. parser: of pytest."""
    group = parser.getgroup("crosscheck", "particle-crosscheck: judge an engine, a test for each case")
    several = {"action": "append", "default": []}
    group.addoption(
        "--crosscheck-engine", metavar="NAME", help="engine: a name, or path.py:Class; repeatable", **several
    )
    group.addoption("--crosscheck-checks", metavar="PATTERN", help="of checks or cases; repeatable", **several)
    group.addoption("--crosscheck-tier", default="quick", metavar="TIER", help="small, quick or full (quick)")
    group.addoption("--crosscheck-seed", type=int, default=0, metavar="N", help="seed of the suite (0)")
    group.addoption("--crosscheck-budget", type=float, metavar="SECONDS", help="run what ends within this time")
    group.addoption("--crosscheck-time-limit", type=float, metavar="SECONDS", help="of one call of an engine (900)")
    group.addoption(
        "--crosscheck-allow-inconclusive", action="store_true", help="inconclusive verdicts are skips, not failures"
    )


def pytest_configure(config: pytest.Config) -> None:
    """Registers the marker; finds the cases that the options ask for. config: of the session.

    pytest.UsageError for an engine, a pattern or a tier that there is not.
    """
    config.addinivalue_line("markers", _MEANING)
    config.stash[_MISTAKES] = []
    if not hasattr(config, "workerinput"):
        config.pluginmanager.register(_Judged(), "crosscheck-judged")
    option = config.option
    if not option.crosscheck_engine:
        given = (option.crosscheck_checks, option.crosscheck_tier, option.crosscheck_seed, option.crosscheck_budget)
        if given != ([], "quick", 0, None):
            raise pytest.UsageError("--crosscheck: there is no engine to judge: add --crosscheck-engine")
        return
    from crosscheck.errors import UsageError
    from crosscheck.pytest_plugin import cases

    try:
        settings = cases.from_options(config)
        if hasattr(config, "workerinput"):
            settings = settings.with_times(config.workerinput.get(_TIMES))
        elif option.crosscheck_budget is not None and not option.collectonly:
            settings = settings.within(option.crosscheck_budget, cases.processes(config))
    except UsageError as error:
        raise pytest.UsageError(f"--crosscheck: {error}") from None
    config.stash[_SETTINGS] = settings


@pytest.hookimpl(optionalhook=True)
def pytest_configure_node(node: Any) -> None:
    """Tells a worker of pytest-xdist what the speeds were measured to be. node: of the worker."""
    settings = node.config.stash.get(_SETTINGS, None)
    if settings is not None and settings.times is not None:
        node.workerinput[_TIMES] = settings.times


def pytest_report_header(config: pytest.Config) -> list[str]:
    """What is judged, in words. config: of the session."""
    settings = config.stash.get(_SETTINGS, None)
    return [] if settings is None else settings.said()


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """A test for each case that the markers ask for. metafunc: of the test function."""
    markers = list(metafunc.definition.iter_markers(MARKER))
    if not markers:
        return
    from crosscheck.errors import UsageError
    from crosscheck.pytest_plugin import cases

    found, ids = [], []
    for marker in reversed(markers):  # the one that is written first comes first
        try:
            settings = cases.from_marker(marker, metafunc.definition.path, metafunc.config)
        except UsageError as error:
            if hasattr(metafunc.config, "workerinput"):  # pytest-xdist knows of errors of collection only
                raise pytest.Collector.CollectError(f"{metafunc.definition.nodeid}: {error}") from None
            metafunc.config.stash[_MISTAKES].append(f"{metafunc.definition.nodeid}: {error}")
            continue
        found += [(settings, case) for case in settings.cases]
        ids += [settings.name(case) for case in settings.cases]
    if FIXTURE not in metafunc.fixturenames:
        metafunc.fixturenames.append(FIXTURE)
    metafunc.parametrize(FIXTURE, found, indirect=True, ids=ids)


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report(
    collector: pytest.Collector,
) -> Generator[None, pytest.CollectReport, pytest.CollectReport]:
    """Adds the cases that the options ask for to the session. collector: the session, or another one."""
    report = yield
    settings = collector.config.stash.get(_SETTINGS, None) if isinstance(collector, pytest.Session) else None
    if settings is not None and report.passed:
        from crosscheck.pytest_plugin import cases

        report.result = [*report.result, *cases.nodes(collector, settings)]
    return report


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """pytest.UsageError for the mistakes in markers. config, items: of the session."""
    mistakes = config.stash[_MISTAKES] + [f"{item.nodeid}: {_NO_CASE}" for item in items if _is_unjudged(item)]
    if mistakes and not hasattr(config, "workerinput"):
        raise pytest.UsageError("\n".join(mistakes))


def pytest_runtest_setup(item: pytest.Item) -> None:
    """Fails a test with the marker that got no case. item: the test."""
    if _is_unjudged(item):
        pytest.fail(_NO_CASE, pytrace=False)


def _is_unjudged(item: pytest.Item) -> bool:
    return isinstance(item, pytest.Function) and item.get_closest_marker(MARKER) is not None and not _is_case(item)


@pytest.fixture
def crosscheck_verdict(request: pytest.FixtureRequest) -> Verdict:
    """The verdict of a case, in a test that is marked with `crosscheck`: a `crosscheck.verdict.Verdict`.

    A skip skips the test; what is red fails it, whatever it does itself. request: of pytest.
    """
    if not hasattr(request, "param"):
        pytest.fail(f"{FIXTURE} is for tests with the marker @pytest.mark.{MARKER}(engine=...)", pytrace=False)
    from crosscheck.pytest_plugin import cases

    settings, case = request.param
    return cases.judged(settings, case, request.node)


def _is_case(item: pytest.Item) -> bool:
    """Whether a test got a case by the marker."""
    return FIXTURE in getattr(getattr(item, "callspec", None), "params", ())


@pytest.hookimpl(tryfirst=True)
def pytest_pyfunc_call(pyfuncitem: pytest.Function) -> None:
    """Judges the case of a marked test, if the test has not, and fails it if that is red. pyfuncitem: the test."""
    if _is_case(pyfuncitem):
        from crosscheck.pytest_plugin import cases

        cases.demand_green(pyfuncitem)


class _Judged:
    """Keeps a session from being green in which nothing was judged of an engine: all of its cases were skipped."""

    def __init__(self) -> None:
        self._outcomes: dict[str, dict[str, str]] = {}

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Takes note of a verdict. report: of a test, perhaps from a worker of pytest-xdist."""
        properties = dict(report.user_properties)
        if OUTCOME in properties:
            self._outcomes.setdefault(str(properties[ENGINE]), {})[report.nodeid] = str(properties[OUTCOME])

    def _unjudged(self) -> list[str]:
        return [name for name, found in self._outcomes.items() if set(found.values()) == {"skip"}]

    def pytest_sessionfinish(self, session: pytest.Session, exitstatus: int) -> None:
        """The exit status is that of no tests where it would be that of success. session, exitstatus: of pytest."""
        if self._unjudged() and exitstatus == pytest.ExitCode.OK:
            session.exitstatus = pytest.ExitCode.NO_TESTS_COLLECTED

    def pytest_terminal_summary(self, terminalreporter: Any) -> None:
        """Says of which engines nothing was judged. terminalreporter: of pytest."""
        for name in self._unjudged():
            text = f"crosscheck: nothing was judged of {name}: {len(self._outcomes[name])} skipped (-rs says why)"
            terminalreporter.write_line(text, red=True)


def pytest_unconfigure() -> None:
    """Ends the workers of this process."""
    if (runner := sys.modules.get("crosscheck.runner")) is not None:
        runner.close_pools()
