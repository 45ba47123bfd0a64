"""From a scenario to a problem: scenario -> system -> model, scenario -> world -> problem."""

from kinolab.loading.build import build_problem as build_problem
from kinolab.loading.build import built as built
from kinolab.loading.build import load as load
from kinolab.loading.find import file_of_machine as file_of_machine
from kinolab.loading.find import find_machine as find_machine
from kinolab.loading.find import find_scenario as find_scenario
from kinolab.loading.find import find_system as find_system
from kinolab.loading.find import names_scenario as names_scenario
from kinolab.loading.tables import read_changed as read_changed
from kinolab.loading.tables import read_table as read_table
from kinolab.loading.tables import read_with_obstacle as read_with_obstacle
from kinolab.loading.targets import start_table as start_table
from kinolab.loading.targets import stated_start as stated_start
