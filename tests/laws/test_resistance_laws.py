"""Laws of resistance to rolling and spinning, from event to event, on thrown wheels, wagons and balls."""

import numpy as np
import pytest

import freebody as fb

G = 9.81


def wagon(rng, **laws):
    """Two wheels under a chassis on a slope, dropped."""
    s = fb.System("wagon")
    a = float(rng.uniform(-0.1, 0.1))
    s.gravity = (G * np.sin(a), -G * np.cos(a), 0)
    chassis = s.body("chassis", fb.box(2, (1, 0.1, 0.3)))
    s.planar("f", s.ground, chassis, coordinate="x y th")
    for k, x in enumerate((-0.4, 0.4)):
        wheel = s.body(f"w{k}", fb.disk(1, 0.1))
        s.hinge(f"h{k}", chassis, wheel, at=(x, 0, 0), axis="z", coordinate=f"q{k}")
        s.contact(f"c{k}", wheel.circle(0.1), s.ground.plane(normal="y"), rolling=0.02, **laws)
    start = {
        "y": 0.1 + float(rng.choice([0, 0.1])),
        "x'": float(rng.normal()),
        "q0'": float(3 * rng.normal()),
    }
    return s, start


def wheel(rng, **laws):
    """A wheel that is thrown into a round valley."""
    s = fb.System("wheel")
    s.gravity = (0, -G, 0)
    body = s.body("wheel", fb.disk(1, 0.1))
    s.planar("f", s.ground, body, coordinate="x y turn")
    s.contact("c", body.circle(0.1), s.ground.circle(1, inside=True), rolling=0.01, **laws)
    return s, {"y": -0.5, "x'": float(rng.normal()), "turn'": float(10 * rng.normal())}


def balls(rng, **laws):
    """A ball that is thrown into a trough of two planes."""
    s = fb.System("trough")
    s.gravity = (0, 0, -G)
    ball = s.body("ball", fb.sphere(1, 0.1))
    s.free("f", s.ground, ball)
    for k, side in enumerate((-1, 1)):
        plane = s.ground.plane(normal=(0, 0.5 * side, 1))
        s.contact(f"c{k}", ball.sphere(0.1), plane, rolling=0.01, spinning=0.005, **laws)
    start = {f"f_{c}": float(10 * rng.normal()) for c in ("wx", "wy", "wz")}
    return s, {"f_z": 0.2, "f_vx": float(rng.normal()), "f_vy": float(rng.normal()), **start}


def ball(rng, **laws):
    """A ball that is thrown on a floor."""
    s = fb.System("ball")
    s.gravity = (0, 0, -G)
    body = s.body("ball", fb.sphere(1, 0.1))
    s.free("f", s.ground, body)
    s.contact("c", body.sphere(0.1), s.ground.plane(normal="z"), rolling=0.01, spinning=0.005, **laws)
    start = {f"f_{c}": float(10 * rng.normal()) for c in ("wx", "wy", "wz")}
    return s, {"f_z": 0.2, "f_vx": float(rng.normal()), "f_vy": float(rng.normal()), **start}


SCENES = [wagon, wheel, balls, ball]


def scene(seed):
    rng = np.random.default_rng(seed)
    mu, e = float(rng.choice([0.05, 0.3, 0.8])), float(rng.choice([0, 0.5]))
    impact = str(rng.choice(["newton", "poisson"]))
    return SCENES[seed % len(SCENES)](rng, friction=mu, restitution=e, impact=impact)


def check(seed):
    s, start = scene(seed)
    motion = fb.simulate(s, 2.0, initial=start, samples=801)
    energy = motion.energy
    assert energy.relative_residual < 1e-9
    assert (np.diff(energy.friction) <= 1e-12).all() and (np.diff(energy.impulses) <= 1e-12).all()
    modes = set()
    for contact in motion.kernels.model.contacts:
        if contact.presser:
            one, presser = motion.contacts[contact.name], motion.contacts[contact.presser]
            N, M = presser.least[:, 0], one.least[:, 1:]
            slip, size = one.slip.reshape(M.shape), np.linalg.norm(M, axis=1)
            limit, fast = float(contact.friction) * N, np.linalg.norm(slip, axis=1) > 1e-6
            np.testing.assert_allclose(one.least[:, 0], N, atol=1e-12 * N.max())
            assert (size <= limit + 1e-9 * N.max()).all()
            assert ((one.mode == "open") == (presser.mode == "open")).all()
            assert np.einsum("ni,ni->n", M, slip).max() <= 1e-12 * G
            assert np.abs(slip[one.mode == "stick"]).max(initial=0) < 1e-8
            fast &= one.mode != "open"
            np.testing.assert_allclose(size[fast], limit[fast], atol=1e-9 * N.max())
            modes |= set(one.mode)
    return motion, modes


@pytest.mark.parametrize("seed", [0, 1, 2, 3])
def test_laws_hold_at_every_moment(seed):
    _, modes = check(seed)
    assert modes - {"open"}


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4, 84))
def test_laws_hold_in_all_scenes(seed):
    check(seed)


def test_resistance_ends_with_an_adhesive_contact_that_is_pulled_off():
    """The force 20 t lifts a wheel of weight 9.81 N that adheres with 4 N at t = 0.6905 s; then it turns freely."""
    s = fb.System("sticky wheel")
    s.gravity = (0, -G, 0)
    body = s.body("wheel", fb.disk(1, 0.1))
    s.planar("f", s.ground, body, coordinate="x y turn")
    s.contact("c", body.circle(0.1), s.ground.plane(), friction=0.3, adhesion=4, rolling=0.002)
    s.force("F", body.origin, (0, "20*t", 0))
    motion = fb.simulate(s, 1, initial={"y": 0.1, "x'": 1, "turn'": -10})
    lifted = (G + 4) / 20
    for name in ("c", "c_rolling"):
        change = motion.modes.of(name)[-1]
        assert change.mode == "open" and change.start == pytest.approx(lifted, rel=1e-12)
    after = motion.t > lifted
    # the wheel rolls, 3/2 m R^2 turn'' = δ (N + A), with N + A = m g + A - 20 t
    slowed = 0.002 * ((G + 4) * lifted - 10 * lifted**2) / (1.5 * 0.1**2)
    assert motion["turn'"][after] == pytest.approx(slowed - 10, rel=1e-9)
    assert motion["c_rolling.gap"] == pytest.approx(motion["c.gap"])
    assert abs(motion.energy.residual).max() < 1e-12


@pytest.mark.parametrize("kind", ["contact", "family"])
def test_what_adheres_resists_rolling_by_both_methods(kind):
    """A wheel that rolls to the left, m = 1 kg, with N + A = 13.81 N: M = δ (N + A), and its margin is 0."""
    s = fb.System("sticky wheel")
    s.gravity = (0, -G, 0)
    body = s.body("wheel", fb.disk(1, 0.1))
    s.planar("f", s.ground, body, coordinate="x y turn")
    laws = {"friction": 0.3, "adhesion": 4, "rolling": 0.002}
    if kind == "contact":
        s.contact("c", body.circle(0.1), s.ground.plane(), **laws)
        names = ("c", "c_rolling")
    else:
        s.contacts("c", [body.sphere(0.1), s.ground.plane()], **laws)
        names = ("c[wheel,ground]", "c[wheel,ground]_rolling")
    for options in {}, {"method": "timestepping", "step": 1e-3}:
        motion = fb.simulate(s, 0.1, initial={"y": 0.1, "x'": 1, "turn'": -10}, **options)
        contact, rolling = (motion.contacts[name] for name in names)
        assert contact.normal[-1] == pytest.approx(G) and rolling.normal[-1] == pytest.approx(G + 4)
        assert np.max(np.abs(rolling.tangential[-1])) == pytest.approx(0.002 * (G + 4))
        assert abs(rolling.margin[-1]) < 1e-12 < contact.margin[-1]
