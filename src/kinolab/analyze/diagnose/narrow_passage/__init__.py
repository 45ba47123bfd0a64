"""By how much is the path too narrow, dynamics aside?"""
