"""Systems that several tests use."""

import numpy
import tanor


def hanging_chain(n: int = 11) -> tanor.System:
    """n - 1 rods of 0.1 m on a support, horizontal; points of 0.1 kg under gravity."""
    positions = numpy.zeros((n, 3))
    positions[:, 0] = 0.1 * numpy.arange(n)
    return tanor.System(
        positions, numpy.full(n, 0.1), supports=[tanor.Support([0])],
        constraints=[tanor.Rods([[i, i + 1] for i in range(n - 1)], name="rods")],
        forces=[tanor.Gravity((0, 0, -9.81))])


def pendulum(displacement=(0, 0, 0)) -> tanor.System:
    return tanor.System([[0, 0, 0], [1, 0, 0]], [1, 1], supports=[tanor.Support([0], displacement=displacement)],
                        constraints=[tanor.Rods([[0, 1]])], forces=[tanor.Gravity((0, 0, -9.81))])
