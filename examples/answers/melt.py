"""The histogram of the tensions in a melt of chains: python3 melt.py melt_generated.json"""
import sys
import numpy
import tanor

scene = tanor.Scene(sys.argv[1], t_end=0.02)
run = tanor.run_scene(scene)
(name,) = run.groups
tension = run[name].tension[-1]
for count, edge in zip(*numpy.histogram(tension, 20)):
    print(f"{edge:10.2f} {count:6d} {'#' * (count * 60 // len(tension))}")
