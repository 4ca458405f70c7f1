"""Exported programs against the kernels of the same trace, on random states."""

from __future__ import annotations

import ctypes
import shutil
import subprocess

import numpy as np
import pytest

import freebody as fb
from freebody.errors import ModelError
from freebody.program.export.recording import identifier
from freebody.program.products import PRODUCTS, product_named, products_of
from freebody.testing import random_system

NAMES = (
    *(name for name in PRODUCTS if name not in ("derivatives", "conditions")),
    "forward_dynamics_by_q",
    "mass_matrix_by_displacement",
)


@pytest.fixture(scope="module")
def program():
    s = random_system(5, bodies=3, driven=True)
    m = s.parameters("extra")
    s.force("extra", s.bodies["b1"].point(0, 1, 0), (m, 0, "atan2(extra, 2) + abs(extra) + min(extra, t)"))
    return fb.compile(s)


def states(program, count, seed=0):
    """Inputs by name; quaternions need not be of unit length."""
    random = np.random.default_rng(seed)
    model = program.model
    sizes = {"q": model.n_q, "u": model.n_u, "udot": model.n_u, "forces": model.n_u}
    given = {name: random.uniform(-1, 1, (count, n)) for name, n in sizes.items()}
    return given, random.uniform(0, 1, count), random.uniform(0.5, 1, (count, len(model.parameters)))


def expected(program, name, given, t, p):
    kernel = program.kernel(name)
    product = product_named(program.model, name)
    keys = [parameter.name for parameter in program.model.parameters]
    rows = []
    for k in range(len(t)):
        c = program.constants(name, dict(zip(keys, p[k], strict=True)))
        rows.append(kernel(t[k], np.concatenate([given[x][k] for x in product.inputs]), c))
    return product.inputs, np.array(rows).reshape(len(t), *product.shape(program.model))


def agree(found, wanted):
    """To round-off: of the largest entry, since terms cancel."""
    assert found.shape == wanted.shape
    assert np.abs(found - wanted).max(initial=0) <= 1e-12 * max(1.0, np.abs(wanted).max(initial=0))


def test_c_with_gcc(program, tmp_path):
    exported = program.to_c(*NAMES, name="machine")
    library = shared(tmp_path, exported)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["m.so", "machine.c", "machine.h"]
    given, t, p = states(program, 3)
    for name in NAMES:
        inputs, wanted = expected(program, name, given, t, p)
        function = getattr(library, f"machine_{name}")
        function.restype = None
        found = np.full_like(wanted, np.nan)
        for k in range(len(t)):
            arrays = [given[x][k].ctypes.data_as(ctypes.c_void_p) for x in (*inputs,)]
            out = found[k : k + 1].ctypes.data_as(ctypes.c_void_p)
            function(ctypes.c_double(t[k]), *arrays, p[k].ctypes.data_as(ctypes.c_void_p), out)
        agree(found, wanted)
    defaults = (ctypes.c_double * len(program.model.parameters)).in_dll(library, "machine_parameters")
    assert np.isnan(defaults[len(defaults) - 1])  # `extra` has none


def test_numpy(program, tmp_path):
    exported = program.to_numpy(*NAMES)
    assert tuple(exported) == NAMES
    given, t, p = states(program, 5)
    for name in NAMES:
        inputs, wanted = expected(program, name, given, t, p)
        agree(exported[name](*(given[x] for x in inputs), t, p), wanted)
        agree(np.asarray(exported[name](*(given[x][0] for x in inputs), t[0], p[0])), wanted[0])
    with pytest.raises(ValueError, match="no default value: extra"):
        exported["mass_matrix"](given["q"])
    (path,) = exported.write(tmp_path / "new")
    space = {}
    exec(path.read_text(), space)
    agree(space["bias"](given["q"], given["u"], t, p), expected(program, "bias", given, t, p)[1])
    assert "freebody" not in exported.source.split('"""')[2]
    with pytest.raises(
        KeyError, match="'poke' is not among the functions written: .*mass_matrix, .*Name it in the call"
    ):
        exported["poke"]


def test_jax(program):
    import jax

    before = jax.config.jax_enable_x64
    jax.config.update("jax_enable_x64", True)
    try:
        exported = program.to_jax("forward_dynamics", "mass_matrix", "kinetic_energy")
        given, t, p = states(program, 3)
        for name in exported:
            inputs, wanted = expected(program, name, given, t, p)
            agree(np.asarray(exported[name](*(given[x] for x in inputs), t, p)), wanted)
        # JAX's own derivative of the export is the derivative of the trace
        found = jax.jacfwd(exported["forward_dynamics"])(given["q"][0], given["u"][0], t[0], p[0])
        agree(np.asarray(found), expected(program, "forward_dynamics_by_q", given, t, p)[1][0])
    finally:
        jax.config.update("jax_enable_x64", before)


def test_casadi(program):
    import casadi

    exported = program.to_casadi("forward_dynamics", "mass_matrix", "kinetic_energy", "reactions")
    given, t, p = states(program, 3)
    for name, function in exported.items():
        inputs, wanted = expected(program, name, given, t, p)
        for k in range(len(t)):
            found = np.array(function(*(given[x][k] for x in inputs), t[k], p[k]))
            agree(found.reshape(wanted[k].shape), wanted[k])
    f = exported["forward_dynamics"]
    q, u = casadi.SX.sym("q", program.model.n_q), casadi.SX.sym("u", program.model.n_u)
    J = casadi.Function("J", [q, u], [casadi.jacobian(f(q, u, t[0], p[0]), q)])
    agree(
        np.array(J(given["q"][0], given["u"][0])),
        expected(program, "forward_dynamics_by_q", given, t, p)[1][0],
    )


def test_all_products_by_default():
    s = fb.System("2 masses")
    s.gravity = (0, 0, -9.81)
    s.slider("guide", s.ground, s.body("block", fb.particle(2)), axis="z", coordinate="z")
    exported = fb.compile(s).to_c()
    assert exported.name == "_2_masses"
    assert exported.header.count("\nvoid ") == len(PRODUCTS) - 2
    assert set(fb.compile(s).to_numpy()) == set(PRODUCTS) - {"derivatives", "conditions"}
    assert (
        fb.compile(s).to_numpy("forward_dynamics")["forward_dynamics"](np.zeros((4, 1)), [0.0]).tolist()
        == [[-9.81]] * 4
    )


def shared(folder, exported):
    """The exported C as a library; no warnings."""
    gcc = shutil.which("gcc") or shutil.which("cc")
    if gcc is None:
        pytest.skip("no C compiler")
    source, _ = exported.write(folder)
    flags = ["-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", "-O0", "-shared", "-fPIC"]
    subprocess.run([gcc, *flags, str(source), "-o", str(folder / "m.so"), "-lm"], check=True)
    return ctypes.CDLL(str(folder / "m.so"))


def wire():
    """A bead on the wire y = c x²."""
    s = fb.System("wire")
    (c,) = [s.parameters(c=0.5)]
    s.gravity = (0, -9.81, 0)
    rail = s.body("rail", fb.particle(0))
    s.slider("along", s.ground, rail, axis="x", coordinate="x")
    s.slider("up", rail, s.body("bead", fb.particle(2)), axis="y", coordinate="y")
    s.constrain(s.expression("y") - c * s.expression("x") ** 2, name="wire")
    return s


def test_a_machine_with_constraints(tmp_path):
    """G = (-2 c x, 1), γ = -2 c x'²; the exported acceleration keeps to it."""
    program = fb.compile(wire(), at=[1.0, 0.5])
    assert products_of(program.model) == tuple(PRODUCTS)
    exported = program.to_numpy()
    assert set(exported) == set(PRODUCTS) - {"derivatives"}
    x, v, c = 1.2, 0.7, 0.5
    q, u = np.array([x, c * x * x]), np.array([v, 2 * c * x * v])
    found = exported["conditions"](q, u)
    agree(found, np.array([[-2 * c * x, 1, -2 * c * v * v]]))
    assert abs(found[0] @ [*exported["forward_dynamics"](q, u), 1]) < 1e-12
    given, t, p = states(program, 3)
    library = shared(tmp_path, program.to_c())
    for name in exported:
        inputs, wanted = expected(program, name, given, t, p)
        agree(exported[name](*(given[x] for x in inputs), t, p), wanted)
        out = np.full_like(wanted[0], np.nan)
        arrays = [given[x][0].ctypes.data_as(ctypes.c_void_p) for x in inputs]
        ends = [a.ctypes.data_as(ctypes.c_void_p) for a in (p[0], out)]
        getattr(library, f"wire_{name}")(ctypes.c_double(t[0]), *arrays, *ends)
        agree(out, wanted[0])
    # without at= what needs no choice of independent conditions
    assert {"conditions", "mass_matrix"} <= set(fb.compile(wire()).to_numpy())
    assert "forward_dynamics" not in fb.compile(wire()).to_numpy()


def blown():
    """A cart under three signals, that end in an error, hold on, and are held between samples."""
    s = fb.System("blown")
    m = s.parameters(m=2.0)
    wind = fb.signal([0, 1, 2], [0, 3, -1], name="wind")
    drift = fb.signal([0.5, 1, 1.5, 2.5], [0, 1, -1, 2], "cubic", name="drift", outside="hold")
    level = fb.signal([0, 1.25], [1, 5], "previous", name="level")
    cart = s.body("cart", fb.particle(m))
    s.slider("rail", s.ground, cart, axis="x", coordinate="x")
    s.force("push", cart, (wind + level * drift, 0, 0))
    return fb.compile(s)


def test_signals_hold_in_every_piece(tmp_path):
    program = blown()
    t = np.array([0, 0.3, 0.5, 0.9, 1, 1.1, 1.25, 1.7, 2])
    wanted = program.forward_dynamics([0.0], [0.0], t, m=3.0)
    slopes = program.derivative("forward_dynamics", "t")([0.0], [0.0], t, m=3.0)
    names = ("forward_dynamics", "forward_dynamics_by_t", "mass_matrix")
    q, p = np.zeros((len(t), 1)), np.array([3.0])

    exported = program.to_numpy(*names)
    assert "PARAMETERS = ('m',)" in exported.source
    agree(exported["forward_dynamics"](q, q, t, p), wanted)
    agree(exported["forward_dynamics_by_t"](q, q, t, p), slopes)
    assert np.isnan(exported["forward_dynamics"](q, q, 2.1))[:, 0].all()  # the wind ends at 2 s
    assert np.isnan(exported["forward_dynamics"](q, q, -0.1))[:, 0].all()

    library = shared(tmp_path, program.to_c(*names, name="blown"))
    found = np.full((len(t) + 1, 1), np.nan)
    for k, at in enumerate([*t, 2.1]):
        zero, out = (ctypes.c_double * 1)(0.0), found[k : k + 1].ctypes.data_as(ctypes.c_void_p)
        library.blown_forward_dynamics(ctypes.c_double(at), zero, zero, (ctypes.c_double * 1)(3.0), out)
    agree(found[:-1], wanted)
    assert np.isnan(found[-1, 0])


def test_signals_in_jax():
    import jax

    jax.config.update("jax_enable_x64", True)
    program = blown()
    t = np.array([0.3, 1.0, 1.7])
    wanted = program.forward_dynamics([0.0], [0.0], t)
    agree(
        np.asarray(program.to_jax("forward_dynamics")["forward_dynamics"](np.zeros((3, 1)), [0.0], t)), wanted
    )


def test_signals_in_casadi():
    program = blown()
    function = program.to_casadi("forward_dynamics")["forward_dynamics"]
    assert function.size1_in("p") == 1
    for t in (0.0, 0.3, 1.0, 1.7, 2.0):
        agree(np.array(function([0.0], [0.0], t, [3.0]))[0], program.forward_dynamics([0.0], [0.0], t, m=3.0))
    assert np.isnan(float(function([0.0], [0.0], 2.1, [3.0])))


def test_a_product_named_twice_is_written_once():
    assert blown().to_c("bias", "bias").source.count("blown_bias(") == 1


def test_a_machine_at_rest(tmp_path):
    """Results without entries keep the leading axes, and the C has no warnings."""
    s = fb.System("post")
    s.weld("weld", s.ground, s.body("post", fb.particle(2)), at=(1, 2, 3))
    program = fb.compile(s)
    exported = program.to_numpy()
    assert exported["forward_dynamics"](np.zeros((4, 0)), np.zeros(0)).shape == (4, 0)
    assert exported["mass_matrix"](np.zeros((4, 0))).shape == (4, 0, 0)
    shared(tmp_path, program.to_c())


def test_names():
    assert [identifier(x) for x in ("a b", "", "while", "double", "é")] == [
        "a_b",
        "model",
        "_while",
        "_double",
        "model",
    ]


def test_wrong_requests(program, tmp_path, monkeypatch):
    with pytest.raises(ModelError, match="Unknown product 'forward'"):
        program.to_c("forward")
    with pytest.raises(
        ModelError, match=r"derivative by one of q, u, displacement, t, parameters, extra, got 'w'"
    ):
        program.to_numpy("forward_dynamics_by_w")
    with pytest.raises(ModelError, match="identifier of C, got 'a b'"):
        program.to_c("bias", name="a b")
    (tmp_path / "file").write_text("")
    with pytest.raises(ModelError, match="is a file"):
        program.to_c("potential_energy").write(tmp_path / "file")
    monkeypatch.setitem(__import__("sys").modules, "casadi", None)
    with pytest.raises(ModelError, match=r"pip install freebody\[casadi\]"):
        program.to_casadi("bias")


def test_numpy_functions_refuse_arrays_of_another_length() -> None:
    s = fb.System("pendulum")
    m, L = s.parameters(m=1.0, L=2.0)
    s.gravity = (0, -9.81, 0)
    s.hinge("pin", s.ground, s.body("bob", fb.particle(m)), to=(0, L, 0), axis="z")
    bias = fb.compile(s).to_numpy("bias")["bias"]
    assert bias([[0.1], [0.2]], [0.0], p=[1.0, 2.0]).shape == (2, 1)
    for q, p, text in (
        ([0.1, 0.2], None, r"Expected q of shape \(1,\), leading axes before it, got shape \(2,\)"),
        (0.1, None, r"Expected q of shape \(1,\), .*got shape \(\)"),
        ([0.1], [1.0, 2.0, 3.0], r"Expected p of shape \(2,\), .*got shape \(3,\)"),
    ):
        with pytest.raises(ValueError, match=text):
            bias(q, [0.0], p=p)
