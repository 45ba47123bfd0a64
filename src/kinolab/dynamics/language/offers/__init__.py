"""Numbers of a machine that become parameters once one asks for them, such as those of a robot.

A machine is compiled with the numbers of its file, so that those which nobody changes cost nothing.
"""

from kinolab.dynamics.language.offers.joint_friction import JointFriction as JointFriction
from kinolab.dynamics.language.offers.lumped_mass import Lump as Lump
from kinolab.dynamics.language.offers.lumped_mass import LumpedMass as LumpedMass
from kinolab.dynamics.language.offers.offer import Offer as Offer
from kinolab.dynamics.language.offers.offer import offered as offered
from kinolab.dynamics.language.offers.offer import taking as taking
