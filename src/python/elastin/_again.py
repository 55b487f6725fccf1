"""What pickle calls to make things again: functions of C++ have no name that it could write down."""

from . import _elastin


def simulation(recipe, state):
    return _elastin._simulation_again(recipe, state)


def strategy(name):
    return _elastin._strategy(name)


def catalog(own):
    return _elastin._catalog(own)
