"""Plots: what they draw is what the trajectory and the linear equations say, and they draw where they are told to."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

import freebody as fb
from freebody.errors import ModelError, SimulationError
from freebody.picture.plots.plots import angular_velocity


@pytest.fixture(scope="module")
def swing() -> fb.Trajectory:
    s = fb.System("pendulum")
    m, L, g = s.parameters(m=2, L=1.5, g=9.81)
    s.gravity = (0, -g, 0)
    bar = s.body("bar", fb.slender_bar(m, L, axis="y"))
    s.hinge("pin", s.ground, bar, to=(0, L / 2, 0), coordinate="theta")
    return fb.simulate(s, until=4, initial={"theta": 1}, events=[fb.event("theta'", name="turn")])


@pytest.fixture(scope="module")
def tumble() -> fb.Trajectory:
    s = fb.System("stone")
    s.free("flight", s.ground, s.body("stone", fb.box(6, (3, 2, 1))))
    start = {"flight_wx": 0.01, "flight_wy": 2, "flight_wz": 0.01}
    return fb.simulate(s, until=20, initial=start)


@pytest.fixture(scope="module")
def coin() -> fb.Trajectory:
    s = fb.System("coin")
    s.free("flight", s.ground, s.body("coin", fb.disk(1, 0.5)))
    return fb.simulate(s, until=10, initial={"flight_wx": 1, "flight_wz": 3})


@pytest.fixture(scope="module")
def oscillator() -> fb.System:
    s = fb.System("oscillator")
    m, k, c = s.parameters(m=1, k=4, c=0.5)
    guide = s.slider("guide", s.ground, s.body("block", fb.particle(m)), coordinate="x")
    s.spring("k", guide, stiffness=k)
    s.damper("c", guide, damping=c)
    return s


def own() -> object:
    return Figure().subplots()


# --- of a trajectory -----------------------------------------------------------------------------------------------


def test_many_events_are_thinned_ticks_on_the_time_axis():
    s = fb.System("oscillator")
    guide = s.slider("guide", s.ground, s.body("block", fb.particle(1)), coordinate="x")
    s.spring("k", guide, stiffness=10**6)
    motion = fb.simulate(s, until=2, initial={"x": 1}, events=[fb.event("x", name="mark")])
    assert len(motion.events) > 600
    ax = motion.plot("x")
    (ticks,) = [line for line in ax.lines if line.get_label() == "mark"]
    times = ticks.get_xdata()
    assert 100 < len(times) <= 301 and np.diff(times).min() >= 1 / 300
    assert {event.time for event in motion.events} >= set(times)
    assert ticks.get_transform() == ax.get_xaxis_transform()
    assert len(fb.plot.history(motion, "x", events=False).lines) == 1


def test_phase_is_the_path_with_its_ends_and_events(swing):
    ax = own()
    assert fb.plot.phase(swing, "theta", ax=ax) is ax
    path, start, end, turns = ax.lines
    assert np.array_equal(path.get_xdata(), swing["theta"]) and np.array_equal(
        path.get_ydata(), swing["theta'"]
    )
    assert start.get_xdata() == [1] and end.get_xdata() == [swing["theta"][-1]]
    assert len(turns.get_xdata()) == len(swing.events)
    assert turns.get_ydata() == pytest.approx(0, abs=1e-9)
    assert (ax.get_xlabel(), ax.get_ylabel()) == (r"$\theta$ [rad]", r"$\dot{\theta}$ [rad/s]")
    assert fb.plot.phase(swing).get_xlabel() == r"$\theta$ [rad]"
    assert fb.plot.phase(swing, "theta", "kinetic_energy").get_ylabel() == "kinetic_energy"


def test_phase_of_what_has_no_rate_is_refused(swing):
    with pytest.raises(
        SimulationError, match="Expected a coordinate whose rate is a speed of the machine, got 'L"
    ):
        fb.plot.phase(swing, "L*theta")


def test_energy_is_the_ledger(swing):
    ax = own()
    assert fb.plot.energy(swing, ax) is ax
    curves = {line.get_label(): line.get_ydata() for line in ax.lines}
    assert list(curves) == ["kinetic T", "potential V", "T + V"]
    assert np.array_equal(curves["T + V"], swing.energy.total)
    assert ax.get_ylabel() == "energy [J]"


def test_energy_shows_work_where_loads_do_work(oscillator):
    motion = fb.simulate(oscillator, until=2, initial={"x": 1})
    assert [line.get_label() for line in fb.plot.energy(motion).lines][-1] == "work W"


def test_reaction_and_residual(swing):
    ax = fb.plot.reaction(swing, "pin", axes="xy")
    assert [line.get_label() for line in ax.lines] == [r"$\mathrm{pin}_{x}$", r"$\mathrm{pin}_{y}$"]
    assert np.array_equal(ax.lines[1].get_ydata(), swing.reactions["pin"].force[:, 1])
    assert fb.plot.energy_residual(swing).lines[1].get_ydata() == pytest.approx(0, abs=1e-8)


def test_trajectory_plot_draws_into_given_axes(swing):
    ax = own()
    assert swing.plot("theta", ax=ax) is ax
    assert ax.lines[0].get_label() == r"$\theta$"


# --- in space ------------------------------------------------------------------------------------------------------


def test_angular_velocity_is_that_of_the_body(tumble):
    w = angular_velocity(tumble, "stone")
    body = np.einsum("nji,nj->ni", tumble.poses["stone"].rotation, w)
    for k, letter in enumerate("xyz"):
        assert body[:, k] == pytest.approx(tumble[f"flight_w{letter}"], abs=1e-12)
    with pytest.raises(SimulationError, match="Unknown body 'ston'"):
        angular_velocity(tumble, "ston")


def test_polhode_lies_on_its_ellipsoid(tumble):
    ax = fb.plot.polhode(tumble, "stone")
    moments = np.sort([6 * (a * a + b * b) / 12 for a, b in ((2, 1), (3, 1), (3, 2))])
    twice_T = 2 * tumble.energy.kinetic[0]
    start = np.array([line.get_data_3d() for line in ax.lines][-1])[:, 0]  # the mark of the start
    assert moments @ start**2 == pytest.approx(twice_T)
    assert "$\\omega_1$" in [text.get_text() for text in ax.texts]


def test_polhode_of_a_body_at_rest_is_refused():
    s = fb.System("stone")
    s.free("flight", s.ground, s.body("stone", fb.box(6, (3, 2, 1))))
    with pytest.raises(fb.FreebodyError, match="got one at rest, whose energy ellipsoid is a point"):
        fb.plot.polhode(fb.simulate(s, 1), "stone")


def test_polhode_of_a_bar_is_refused(swing):
    with pytest.raises(SimulationError, match="three moments of inertia above zero"):
        fb.plot.polhode(swing, "bar")


def test_cones_touch_along_the_angular_velocity(coin):
    for at in (0.0, 2.5):
        ax = fb.plot.cones(coin, "coin", at=at)
        assert len([c for c in ax.collections if isinstance(c, Poly3DCollection)]) == 2
        rims = [np.array(line.get_data_3d()).T for line in ax.lines if len(line.get_data_3d()[0]) > 10]
        w = angular_velocity(coin, "coin")[np.argmin(np.abs(coin.t - at))]
        w /= np.linalg.norm(w)
        for rim in rims:
            assert np.linalg.norm(rim, axis=1) == pytest.approx(1)
            assert np.min(np.linalg.norm(rim - w, axis=1)) < 1e-9
        # of a symmetric body both are right circular cones, about its momentum and about its axis
        H = np.array([0.25, 0, 1.5])
        axis = coin.poses["coin"].rotation[np.argmin(np.abs(coin.t - at)), :, 2]
        assert np.ptp(rims[0] @ H) < 1e-6 and np.ptp(rims[1] @ axis) < 1e-6


def test_cones_refuse_what_has_none(swing, coin):
    with pytest.raises(SimulationError, match="Expected a body that turns all the time"):
        fb.plot.cones(swing, "bar")
    with pytest.raises(SimulationError, match="Expected a time from 0 to 10 s, got 11 s"):
        fb.plot.cones(coin, "coin", at=11)


# --- linear and steady motions -------------------------------------------------------------------------------------


def test_mode_shapes_have_a_bar_for_each_coordinate():
    from freebody.gallery import entries

    linear = fb.linearize(entries()["double-pendulum"].build(), values={})
    panels = fb.plot.mode_shapes(linear)
    modes = linear.modes()
    assert len(panels) == len(modes) == 2
    for panel, mode in zip(panels, modes, strict=True):
        assert [bar.get_width() for bar in panel.patches] == pytest.approx(
            [mode.shape[n] for n in ("theta_1", "theta_2")]
        )
        assert f"{mode.frequency:.4g} rad/s" in panel.get_title(loc="left")
    ax = Figure().subplots(2, 1)
    assert fb.plot.mode_shapes(modes, ax)[0] is ax[0]
    with pytest.raises(ModelError, match="Expected an axes for each of 2 modes, got 1"):
        fb.plot.mode_shapes(modes, own())


def test_mode_shapes_of_symbols_are_refused(oscillator):
    with pytest.raises(ModelError, match="Expected linear equations in numbers to plot their modes"):
        fb.plot.mode_shapes(fb.linearize(oscillator))


def test_root_locus_follows_each_eigenvalue(oscillator):
    linear = fb.linearize(oscillator)
    c = np.linspace(0, 3.9, 40)
    ax = own()
    assert fb.plot.root_locus(linear, "c", c, ax) is ax
    expected = -c / 2 + 1j * np.sqrt(4 - c**2 / 4)  # s² + c s + 4 = 0
    found = []
    for line in ax.collections:
        parts = line.get_segments()
        points = np.array([*(p[0] for p in parts), parts[-1][1]])
        found.append(points[:, 0] + 1j * points[:, 1])
    found.sort(key=lambda s: -s[0].imag)
    assert found[0] == pytest.approx(expected, abs=1e-9) and found[1] == pytest.approx(
        expected.conj(), abs=1e-9
    )


def test_root_locus_over_the_parameter_and_of_a_function(oscillator):
    ax = fb.plot.root_locus(lambda k: [1j * np.sqrt(k), -1j * np.sqrt(k)], "k", [1, 4, 9], over="parameter")
    assert ax.lines[1].get_ydata() == pytest.approx([1, 2, 3])
    assert ax.get_xlabel() == "$k$"
    with pytest.raises(ModelError, match="Unknown parameter 'd' of the linear equations"):
        fb.plot.root_locus(fb.linearize(oscillator), "d", [1, 2])
    with pytest.raises(ModelError, match="Expected linear equations with 'c' as a symbol, got numbers"):
        fb.plot.root_locus(fb.linearize(oscillator, values={}), "c", [1, 2])
    with pytest.raises(ModelError, match="at least two finite values"):
        fb.plot.root_locus(fb.linearize(oscillator), "c", [1])
    with pytest.raises(ModelError, match="Expected over='plane' or over='parameter', got 'time'"):
        fb.plot.root_locus(fb.linearize(oscillator), "c", [1, 2], over="time")
    with pytest.raises(ModelError, match="or a function of 'c' that returns them, got 3"):
        fb.plot.root_locus(3, "c", [1, 2])


def test_bifurcation_of_the_bead_on_a_hoop():
    s = fb.System("bead on a hoop")
    m, R, g, w = s.parameters(m=1, R=1, g=9.81, w=5)
    s.gravity = (0, 0, -g)
    hoop = s.body("hoop", fb.MassProperties(0, (0, 0, 0), ((0, 0, 0), (0, 0, 0), (0, 0, 0))))
    s.hinge("spin", s.ground, hoop, axis="z", coordinate=w * s.t)
    s.hinge("arm", hoop, s.body("bead", fb.particle(m)), to=(0, 0, R), axis="y", coordinate="theta")
    branches = fb.steady_motions(s).continuation("w", (0.5, 8), values={})
    ax = own()
    assert fb.plot.bifurcation(branches, "theta", ax) is ax
    lines = {
        label: [x for x in ax.lines if x.get_linestyle() == style]
        for label, style in (("yes", "-"), ("no", "--"))
    }
    critical = np.sqrt(9.81)
    for line in lines["yes"]:  # θ = 0 below, the two others above: cos θ = g / (R w²)
        x, y = line.get_xdata(), np.asarray(line.get_ydata())
        here = np.isfinite(y) & (np.abs(y) > 1e-3)
        assert np.cos(y[here]) == pytest.approx(9.81 / x[here] ** 2, abs=1e-9)
        assert np.all(x[np.isfinite(y) & (np.abs(y) < 1e-3)] < critical + 0.2)
    assert lines["no"]
    marks = [line.get_xdata() for line in ax.lines if line.get_linestyle() == "None"]
    assert marks and all(np.ravel(x) == pytest.approx(critical, abs=1e-3) for x in marks)
    assert {text.get_text() for text in ax.get_legend().get_texts()} == {
        "stable",
        "not stable",
        "bifurcation",
    }
    with pytest.raises(ModelError, match="Unknown unknown 'phi' of the steady motions"):
        fb.plot.bifurcation(branches, "phi")
    with pytest.raises(ModelError, match="Expected at least one branch"):
        fb.plot.bifurcation([])


def test_reactions_are_plotted_with_their_units(swing):
    panels = swing.plot(["pin", "pin.force.y", "pin.moment.z"])
    assert [panel.get_ylabel() for panel in panels] == ["[N]", "pin.moment.z [N m]"]
    assert (panels[0].lines[0].get_ydata() == swing["pin"]).all()


def test_curves_have_their_names_beside_them_where_their_ends_are_apart():
    from freebody.picture.plots.plots import BESIDE

    s = fb.System("apart")
    for name in "ab":
        s.slider(name, s.ground, s.body(name, fb.particle(1)), axis="x", coordinate=f"x_{name}")
        s.hinge(f"turn_{name}", s.ground, s.body(f"rotor_{name}", fb.disk(1, 1)), coordinate=f"phi_{name}")
    motion = fb.simulate(s, 1, initial={"x_a'": 1, "x_b'": 2, "phi_a'": 1, "phi_b'": 2})
    sliders, turns = fb.plot.history(motion)
    assert sliders.get_legend() is None and {text.get_text() for text in sliders.texts} == {
        "$x_{a}$",
        "$x_{b}$",
    }
    assert [text.xy[1] for text in sliders.texts] == pytest.approx([1, 2])
    assert turns.child_axes[0]._pos == BESIDE  # degrees, beyond the names
    close = fb.simulate(s, 1, initial={"x_a'": 1, "x_b'": 1.01, "phi_a'": 1})
    panel = fb.plot.history(close, ["x_a", "x_b"])
    assert not panel.texts and len(panel.get_legend().get_texts()) == 2
