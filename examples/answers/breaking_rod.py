"""The instant at which a rod of 1 m breaks at 20 N: 1 kg swings on it, let go from the side."""
import tanor

system = tanor.System([(0, 0, 0), (1, 0, 0)], 1.0, supports=[tanor.Support([0])], units="si",
                      constraints=[tanor.Rods([[0, 1]], name="rod")], forces=[tanor.Gravity((0, 0, -9.81))])
swing = tanor.Simulation(system, rtol=1e-12)
swing.add_event(when="tension(rod) > 20", do="break")
tanor.run(swing, 1.0)
(passage,) = swing.passages
print(f"{passage.member} breaks at t = {passage.time:.10g} s")
